# SPDX-License-Identifier: BSD-3-Clause
# Sums up a run of all tests: which failed, which were skipped and why, and how many of each.
#   awk -f summary.awk CTEST_LOG FOLDER/NAME_test.tsv...     (the lines that test_main.cpp writes)
# An entry of ctest that writes no such lines (a script) counts as one test.
BEGIN { FS = "\t" }

FNR == 1 {
  binary = FILENAME
  sub(/.*\//, "", binary)
  sub(/_test\.tsv$/, "", binary)
}

FILENAME == ARGV[1] {
  if ($0 !~ /^ *[0-9]+\/[0-9]+ +Test +#[0-9]+: /) next
  entry = $0
  sub(/^[^:]*: /, "", entry)
  sub(/ .*/, "", entry)
  state[entry] = /Passed/ ? "passed" : /Skipped/ ? "skipped" : "failed"
  next
}

$1 == "started" { open[binary] = $2; next }
{ delete open[binary]; ++tests[binary] }
$1 == "passed" { ++passed }
$1 == "failed" { fail(binary, $2) }
$1 == "skipped" { skip($2, $3) }

END {
  for (entry in state) {
    if (entry in open) fail(entry, open[entry] " (the program ended in it)")
    else if (state[entry] == "failed" && !(entry in failures)) fail(entry, "")
    else if (entry in tests) continue
    else if (state[entry] == "skipped") skip(entry, "its script says so")
    else ++passed
  }
  if (failed > 0) print "failed:\n" failed_names
  for (reason in skipped_names) print "skipped, " reason ":\n" skipped_names[reason]
  printf "%d passed, %d failed, %d skipped\n", passed, failed, skipped
}

function fail(entry, name) {
  ++failed
  ++failures[entry]
  failed_names = failed_names "  " entry " " name "\n"
}

function skip(name, reason) {
  ++skipped
  skipped_names[reason] = skipped_names[reason] "  " name "\n"
}
