"""What shows that lissom is right: the numerical lab, questions with known answers, hard cases.

The commands of the same names run them. The simulator imports nothing of this.
"""
