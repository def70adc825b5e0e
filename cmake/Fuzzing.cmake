# SPDX-License-Identifier: BSD-3-Clause
# Every target with coverage, AddressSanitizer and UndefinedBehaviorSanitizer, for the programs of test/fuzz.
if(NOT CMAKE_CXX_COMPILER_ID MATCHES "Clang")
  message(FATAL_ERROR "XVIEW_BUILD_FUZZ needs clang, found ${CMAKE_CXX_COMPILER_ID}: -DCMAKE_CXX_COMPILER=clang++, or ./run fuzz")
endif()
add_compile_options(-O1 -g1 -UNDEBUG -fno-omit-frame-pointer -fno-sanitize-recover=all
  -fsanitize=fuzzer-no-link,address,undefined,float-cast-overflow -fno-sanitize=vptr)
add_link_options(-fsanitize=address,undefined)
# The convention of libFuzzer for what stands in the way of random inputs, such as checksums.
add_compile_definitions(FUZZING_BUILD_MODE_UNSAFE_FOR_PRODUCTION)
