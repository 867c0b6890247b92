"""`python -m precomp` is the command `precomp`."""

from precomp._command import main

if __name__ == "__main__":
    main()
