"""Exit codes other than 0 (success)."""

#: The simulation failed, or something could not be written.
FAILED = 1
BAD_INPUT = 2
#: A case of the validation gallery is outside its tolerance.
OUTSIDE_TOLERANCE = 3
#: The stress test regressed.
REGRESSED = 3
INTERRUPTED = 130
