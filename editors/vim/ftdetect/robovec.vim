autocmd BufNewFile,BufRead *.rvir setfiletype rvir
autocmd BufNewFile,BufRead *.rules setfiletype robovecrules
