"""The verdicts of a file, as docs/grade.md lists them."""

CORRECT_TO_RESOLUTION = "correct"
CORRECT_TO_SINGLE = "correct to single precision"
CORRECT_TO_DIGITS = "correct to the printed digits"
CORRECT_TO_NOISE = "correct to its noise"
EXPLAINED_WHOLLY = "explained"
EXPLAINED_PARTLY = "explained in part"
UNEXPLAINED = "not explained"
TOO_COARSE = "too coarse to grade"
TOO_LITTLE = "too little to explain"
TOO_FEW = "too few rows to explain"
# Verdicts that only contact has: right but for delays of a step; and nothing that a law can be held to.
CORRECT_TO_STEP = "correct to its step"
NOTHING_SEEN = "no contact to grade"
# Verdicts that only readings of a sensor have.
NO_MISTAKE_SEEN = "no mistake above its noise"
FOLLOWS_MOTION = "right for the motion in the file"
# The verdicts of what is right, as far as a file shows.
RIGHT = (CORRECT_TO_RESOLUTION, CORRECT_TO_SINGLE, CORRECT_TO_DIGITS, CORRECT_TO_STEP, CORRECT_TO_NOISE)
