#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The reader of the package beside this file, under the name that it had before there was one.

As a program it prints one ray:  raymap_reader.py MAP RAY
"""
import sys

from raymap import reader

if __name__ == "__main__":
    sys.exit(reader.main(sys.argv[1:]))
sys.modules[__name__] = reader
