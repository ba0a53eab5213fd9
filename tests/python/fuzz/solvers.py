NAME = "solvers"
def prepare(): pass
