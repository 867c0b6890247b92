"""`python -m precomp` is the command `precomp`."""

from precomp._command import main

main()
