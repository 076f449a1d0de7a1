This is a letter, not a program.
It has two lines.
