# SPDX-License-Identifier: MIT
"""A lens in Zemax's format, for the tests of `import`, which count its lines."""

ZMX = """UNIT MM X W X CM MR CPMM
ENPD 10
FTYP 0 0 2 2
YFLN 0 5
WAVM 1 0.48 1
WAVM 2 0.65 2
SURF 0
  DISZ INFINITY
SURF 1
  STOP
  CURV 0.02
  DISZ 4
  GLAS N-BK7 0 0 1.5 40
  DIAM 6 1 0 0 1 ""
SURF 2
  CURV -0.02
  DISZ 48
SURF 3
  DISZ 0
"""
