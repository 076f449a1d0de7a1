" The text form of robovec (docs/text-format.md).
if exists("b:current_syntax")
  finish
endif
syntax match rvirComment "//.*$"
syntax region rvirText start=+"+ skip=+\\.+ end=+"+
syntax match rvirValue "%[A-Za-z0-9_.]\+"
syntax match rvirPlace "@\d\+:[0-9:-]*\|!\d\+"
syntax match rvirNumber "\<\d\+\(\.\d\+\)\?\([eE][-+]\?\d\+\)\?\>"
syntax match rvirDeclared "^\s*\(function\|source\|meta\|in\|out\|call\|places\|schedule\|preload\)\>"
syntax match rvirWord "\<\(on\|at\|read\|write\|buffer\|bound\|cycles\|hash\|history\)\>"
syntax keyword rvirLevel equations atomic scheduled placed
syntax match rvirOperation "\<\(copy\|sin\|cos\|sqrt\|fma\|fms\|fnma\)\ze("
highlight default link rvirComment Comment
highlight default link rvirText String
highlight default link rvirValue Identifier
highlight default link rvirPlace SpecialComment
highlight default link rvirNumber Number
highlight default link rvirDeclared Statement
highlight default link rvirWord Keyword
highlight default link rvirLevel Type
highlight default link rvirOperation Function
let b:current_syntax = "rvir"
