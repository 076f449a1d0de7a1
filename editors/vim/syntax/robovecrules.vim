" Rewriting rules of robovec (docs/rules.md).
if exists("b:current_syntax")
  finish
endif
syntax match rulesComment "#.*$"
syntax region rulesText start=+"+ skip=+\\.+ end=+"+
syntax match rulesName "^\s*rule\s\+\zs[A-Za-z0-9_-]\+"
syntax match rulesStatement "^\s*rule\>\|\<when\>"
syntax match rulesClass "\<class=\(exact\|real-trig\|real\)\>"
syntax match rulesArrow "<=>\|=>"
syntax match rulesNumber "\<\d\+\(\.\d\+\)\?\>"
syntax match rulesOperation "\<\(copy\|sin\|cos\|sqrt\|fma\|fms\|fnma\)\ze("
highlight default link rulesComment Comment
highlight default link rulesText String
highlight default link rulesName Identifier
highlight default link rulesStatement Statement
highlight default link rulesClass Type
highlight default link rulesArrow Operator
highlight default link rulesNumber Number
highlight default link rulesOperation Function
let b:current_syntax = "robovecrules"
