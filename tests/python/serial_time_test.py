#!/usr/bin/env python3
"""tools/serial_time.py: stacks from the text of `perf script`, and which of them are serial."""
import pathlib
import sys
import unittest

TOOLS = pathlib.Path(__file__).resolve().parents[2] / "tools"
sys.dont_write_bytecode = True
sys.path.insert(0, str(TOOLS))
import serial_time  # noqa: E402

TEXT = """\
            2f0e myrialux::(anonymous namespace)::sort_into_slices(std::span<Row, 4ul>)+0x1f (/b/myrialux)
            1f0e myrialux::parallel::split_range(unsigned long, unsigned long)+0x3 (/b/myrialux)
            0f0e main+0xe (/b/myrialux)
            0e0e _start+0x21 (/b/myrialux)

    7f5fc3fe7f10 __memset_avx512_unaligned_erms+0x150 (/lib/libc.so.6)
            2f0e myrialux::FrameState::FrameState(int, int, myrialux::Filter const&)+0x1f (/b/myrialux)
            0e0e _start+0x21 (/b/myrialux)

    7f5fc3fe7f10 do_lookup_x+0x150 (/lib/ld.so)
            0e0e _start+0x21 (/lib/ld.so)

    7f5fc3fe7f10 [unknown] (/lib/libembree3.so.3)

"""


class Stacks(unittest.TestCase):
    def setUp(self):
        self.stacks = list(serial_time.stacks(TEXT))

    def test_are_read_from_the_innermost_function_on(self):
        self.assertEqual([len(s) for s in self.stacks], [4, 3, 2, 1])
        self.assertEqual(self.stacks[0][2:], ["main", "_start"])

    def test_are_parallel_below_a_loop_and_broken_without_a_beginning(self):
        self.assertEqual([serial_time.kind(s) for s in self.stacks], ["parallel", "serial", "serial", "broken"])

    def test_are_named_by_the_innermost_own_function(self):
        self.assertEqual([serial_time.own_function(s) for s in self.stacks[:3]],
                         ["sort_into_slices", "FrameState::FrameState", "_start"])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
