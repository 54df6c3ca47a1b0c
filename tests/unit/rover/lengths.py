"""The rover's frames with their number of data bytes (spec/rover.md, Frames), by direction."""

UP = {100: 2, 101: 1, 115: 1, 119: 1, 120: 1}
DOWN = {104: 6, 105: 6, 106: 6, 107: 6, 108: 8, 109: 6, 110: 8, 111: 12, 112: 6, 113: 3, 114: 3, 116: 1, 117: 1, 118: 1}
ALL = UP | {102: 3, 103: 3} | DOWN
