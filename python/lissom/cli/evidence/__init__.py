"""Verification of lissom: the numerical lab, the validation gallery and the stress test.

The commands of the same names run them. The simulator does not depend on this package.
"""
