// SPDX-License-Identifier: BSD-3-Clause
#include "io/codecs.h"

#include <cstdlib>
#include <mutex>
#include <new>
#include <opencv2/imgcodecs.hpp>

namespace xview::io {
namespace {

/// OpenCV refuses EXR unless this is in the environment before it looks for the first time.
void allowExr() {
  static std::once_flag once;
  std::call_once(once, [] { setenv("OPENCV_IO_ENABLE_OPENEXR", "1", 0); });
}

}  // namespace
}  // namespace xview::io

void xviewDecodeImage(const unsigned char* bytes, std::size_t size, cv::Mat& image,
                      std::string& problem) {
  xview::io::allowExr();
  const cv::Mat file(1, static_cast<int>(size), CV_8U, const_cast<unsigned char*>(bytes));
  try {
    image = cv::imdecode(file, cv::IMREAD_UNCHANGED);
    if (image.empty()) problem = "cannot be decoded as an image; is it damaged?";
  } catch (const cv::Exception& e) {
    if (e.code == cv::Error::StsNoMem) throw std::bad_alloc();
    problem = "cannot be decoded: " + e.err;
  }
}
