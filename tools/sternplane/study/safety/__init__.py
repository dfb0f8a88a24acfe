"""The safety study: every fault, at several times of a mission, judged by the truth."""
