def cons_jdqd(Jdqd, s):
    print("Your symbolic files seem obsolete. Please regenerate them.")
    s.flag_stop = 1
