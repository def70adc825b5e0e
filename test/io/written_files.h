// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdio>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string>

#include "xview/types/error.h"

namespace xview::test {

inline void writeBytes(const std::string& path, const std::string& bytes) {
  std::remove(path.c_str());  // some file systems are slow to overwrite
  std::ofstream(path, std::ios::binary) << bytes;
}

inline std::string readBytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream bytes;
  bytes << file.rdbuf();
  return bytes.str();
}

/// The bytes of a number as they stand in memory, i.e. little-endian.
template <class T>
std::string raw(T value) {
  std::string bytes(sizeof(T), '\0');
  std::memcpy(bytes.data(), &value, sizeof(T));
  return bytes;
}

/// The message of the Error that a call throws; empty if it throws none.
template <class Call>
std::string errorOf(const Call& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

}  // namespace xview::test
