// SPDX-License-Identifier: BSD-3-Clause
// Headers of others that most tests include, as src/precompiled.h has those of the program.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "../src/precompiled.h"
