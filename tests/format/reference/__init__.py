# SPDX-License-Identifier: MIT
"""The tests' own reader of maps; sys.path has examples/python."""
