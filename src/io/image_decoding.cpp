// SPDX-License-Identifier: BSD-3-Clause
#include "image_decoding.h"

#include <libdeflate.h>

#include <algorithm>
#include <boost/endian/conversion.hpp>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>
#include <opencv2/core.hpp>
#include <string_view>

#include "codecs.h"
#include "image_headers.h"
#include "input_file.h"
#include "process/library_chatter.h"
#include "process/module.h"
#include "xview/base/error.h"

namespace xview::io {
namespace {

using Byte = unsigned char;

constexpr Byte kSignature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
constexpr std::uint64_t kMaxSide = 32768;
constexpr std::int64_t kMaxPixels = 1 << 26;   ///< of images whose size is not known
constexpr std::uint64_t kMaxInflation = 1032;  ///< deflate cannot expand a byte to more

#ifdef FUZZING_BUILD_MODE_UNSAFE_FOR_PRODUCTION
constexpr bool kLooksAtChecksums = false;  // random changes are to reach what is behind them
#else
constexpr bool kLooksAtChecksums = true;
#endif

/// 0 for a colour type that does not exist.
int channelsOf(PngColor color) {
  static constexpr int kBevChannels[] = {1, 0, 3, 1, 2, 0, 4};
  const auto type = static_cast<std::size_t>(color);
  return type < std::size(kBevChannels) ? kBevChannels[type] : 0;
}

PngHeader parseHeader(const std::string& path, const unsigned char* data, std::size_t size) {
  if (size != 13) throw Error(path, fmt::format("PNG header of {} bytes, expected 13", size));
  const std::uint32_t width = boost::endian::load_big_u32(data),
                      height = boost::endian::load_big_u32(data + 4);
  if (width == 0 || height == 0 || width > kMaxSide || height > kMaxSide) {
    throw Error(path, fmt::format("PNG of {} x {} pixels, expected 1 to {} each way", width, height,
                                  kMaxSide));
  }
  PngHeader header;
  header.width = static_cast<int>(width);
  header.height = static_cast<int>(height);
  header.bits = data[8];
  header.color = static_cast<PngColor>(data[9]);
  header.interlaced = data[12] != 0;
  if (channelsOf(header.color) == 0 || header.bits == 0 || header.bits > 16) {
    throw Error(path,
                fmt::format("PNG with colour type {} and {} bits per channel", data[9], data[8]));
  }
  return header;
}

std::string describe(const PngHeader& header) {
  static constexpr const char* kNames[] = {"grey", "", "RGB", "palette", "grey+alpha", "", "RGBA"};
  return fmt::format("{}-bit {}", header.bits, kNames[static_cast<int>(header.color)]);
}

// ---- pixels of a PNG

bool isReadable(const PngHeader& header) {
  return header.color != PngColor::palette && (header.bits == 8 || header.bits == 16);
}

/// The pixels that stand together in the data: every n-th column and row from a first one.
struct Pass {
  int x, y, dx, dy;
  int columnsOf(int width) const { return (width - x + dx - 1) / dx; }
  int rowsOf(int height) const { return (height - y + dy - 1) / dy; }
};

std::vector<Pass> passesOf(const PngHeader& header) {
  if (!header.interlaced) return {{0, 0, 1, 1}};
  return {{0, 0, 8, 8}, {4, 0, 8, 8}, {0, 4, 4, 8}, {2, 0, 4, 4},
          {0, 2, 2, 4}, {1, 0, 2, 2}, {0, 1, 1, 2}};  // section 8.2
}

/// Bytes of the rows of a pass, each with the byte in front that names its filter.
std::size_t bytesOf(int columns, int rows, std::size_t pixel_bytes) {
  if (columns == 0) return 0;
  return static_cast<std::size_t>(rows) * (1 + pixel_bytes * static_cast<std::size_t>(columns));
}

/// The data chunks of the file, one after the other, unpacked; empty if they do not hold `size`
/// bytes.
std::vector<Byte> inflate(const PngHeader& header, const std::vector<Byte>& bytes,
                          std::size_t size) {
  std::vector<Byte> joined;  // of several pieces
  for (const PngHeader::Piece& piece : header.data) {
    if (header.data.size() == 1) break;
    joined.insert(joined.end(), &bytes[piece.begin], &bytes[piece.begin] + piece.size);
  }
  const std::unique_ptr<libdeflate_decompressor, void (*)(libdeflate_decompressor*)> inflater(
      libdeflate_alloc_decompressor(), libdeflate_free_decompressor);
  std::vector<Byte> rows(size);
  const bool is_one = header.data.size() == 1;
  const auto result = libdeflate_zlib_decompress(
      inflater.get(), is_one ? &bytes[header.data[0].begin] : joined.data(),
      is_one ? header.data[0].size : joined.size(), rows.data(), rows.size(), nullptr);
  if (result != LIBDEFLATE_SUCCESS) rows.clear();
  return rows;
}

// The filters of the PNG specification, section 9, undone in place. `kStep` is the size of a pixel,
// known to the compiler so that it keeps the pixel on the left in registers.

template <std::size_t kStep>
void undoSub(Byte* row, std::size_t size) {
  Byte left[kStep] = {};
  for (std::size_t i = 0; i < size; i += kStep) {
    for (std::size_t c = 0; c < kStep; ++c) row[i + c] = left[c] += row[i + c];
  }
}

void undoUp(Byte* row, const Byte* above, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) row[i] = static_cast<Byte>(row[i] + above[i]);
}

template <std::size_t kStep>
void undoAverage(Byte* row, const Byte* above, std::size_t size) {
  Byte left[kStep] = {};
  for (std::size_t i = 0; i < size; i += kStep) {
    for (std::size_t c = 0; c < kStep; ++c) {
      row[i + c] = left[c] = static_cast<Byte>(row[i + c] + (left[c] + above[i + c]) / 2);
    }
  }
}

/// Left, above or above left: the nearest to left + above - above left.
Byte paeth(int left, int above, int corner) {
  const int to_left = std::abs(above - corner), to_above = std::abs(left - corner);
  const int to_corner = std::abs(left + above - 2 * corner);
  const int upper = to_above <= to_corner ? above : corner;
  return static_cast<Byte>(to_left <= to_above && to_left <= to_corner ? left : upper);
}

template <std::size_t kStep>
void undoPaeth(Byte* row, const Byte* above, std::size_t size) {
  Byte left[kStep] = {}, corner[kStep] = {};
  for (std::size_t i = 0; i < size; i += kStep) {
    for (std::size_t c = 0; c < kStep; ++c) {
      const Byte guess = paeth(left[c], above[i + c], corner[c]);
      corner[c] = above[i + c];
      row[i + c] = left[c] = static_cast<Byte>(row[i + c] + guess);
    }
  }
}

/// False if there is no such filter.
template <std::size_t kStep>
bool undoFilter(Byte* row, const Byte* above, std::size_t size) {
  const Byte filter = *row++;
  if (filter == 1) undoSub<kStep>(row, size);
  if (filter == 2) undoUp(row, above, size);
  if (filter == 3) undoAverage<kStep>(row, above, size);
  if (filter == 4) undoPaeth<kStep>(row, above, size);
  return filter <= 4;
}

using UndoFilter = bool (*)(Byte*, const Byte*, std::size_t);
/// By the bytes of a pixel; the channels and depths that there are make no others.
constexpr UndoFilter kUndoFilterOf[] = {nullptr,       undoFilter<1>, undoFilter<2>,
                                        undoFilter<3>, undoFilter<4>, nullptr,
                                        undoFilter<6>, nullptr,       undoFilter<8>};

/// Samples in the order of the file to pixels in OpenCV's order.
template <class Sample>
void storeRow(const Byte* row, int channels, cv::Mat& image, int y) {
  const auto sample = [&](std::size_t i) {
    if constexpr (sizeof(Sample) == 1)
      return row[i];
    else
      return static_cast<Sample>(row[2 * i] << 8 | row[2 * i + 1]);
  };
  Sample* out = image.ptr<Sample>(y);
  const auto samples = static_cast<std::size_t>(image.cols * channels);
  if (channels == 1) {
    for (std::size_t i = 0; i < samples; ++i) out[i] = sample(i);
    return;
  }
  if (channels == 2) {
    for (std::size_t i = 0; i < samples; i += 2) {
      out[2 * i] = out[2 * i + 1] = out[2 * i + 2] = sample(i);
      out[2 * i + 3] = sample(i + 1);
    }
    return;
  }
  const auto step = static_cast<std::size_t>(channels);
  for (std::size_t i = 0; i < samples; i += step) {
    out[i] = sample(i + 2);
    out[i + 1] = sample(i + 1);
    out[i + 2] = sample(i);
    if (channels == 4) out[i + 3] = sample(i + 3);
  }
}

/// The pixels of one pass, whose rows begin at `rows`; false if a row has an unknown filter.
bool decodePass(const PngHeader& header, Byte* rows, cv::Mat& image) {
  const int channels = channelsOf(header.color);
  const auto pixel_bytes = static_cast<std::size_t>(channels * header.bits / 8);
  const std::size_t row_bytes = pixel_bytes * static_cast<std::size_t>(image.cols);
  const std::vector<Byte> nothing(row_bytes, 0);
  const Byte* above = nothing.data();
  const UndoFilter undoRow = kUndoFilterOf[pixel_bytes];
  for (int y = 0; y < image.rows; ++y) {
    Byte* row = rows + (1 + row_bytes) * static_cast<std::size_t>(y);
    if (!undoRow(row, above, row_bytes)) return false;
    above = row + 1;
    if (header.bits == 8)
      storeRow<Byte>(above, channels, image, y);
    else
      storeRow<std::uint16_t>(above, channels, image, y);
  }
  return true;
}

void scatter(const cv::Mat& part, const Pass& pass, cv::Mat& image) {
  const std::size_t bytes = image.elemSize();
  for (int y = 0; y < part.rows; ++y) {
    for (int x = 0; x < part.cols; ++x)
      std::memcpy(image.ptr(pass.y + y * pass.dy, pass.x + x * pass.dx), part.ptr(y, x), bytes);
  }
}

// ---- any image

bool isNamedPng(const std::string& path) {
  return path.size() >= 4 && (path.compare(path.size() - 4, 4, ".png") == 0 ||
                              path.compare(path.size() - 4, 4, ".PNG") == 0);
}

cv::Mat decodeSoundPng(const std::string& path, const std::vector<unsigned char>& bytes,
                       const SizeCheck& check) {
  const PngHeader header = checkPng(path, bytes);
  if (header.color == PngColor::palette || header.bits < 8) {
    throw Error(path,
                "expected 8 or 16 bits per channel without a palette, found " + describe(header));
  }
  check(header.width, header.height);
  cv::Mat image = decodePng(header, bytes);
  if (!image.empty()) return image;
  throw Error(path, fmt::format("PNG damaged: its data do not unpack to {} x {} pixels of {}; is "
                                "it written to its end?",
                                header.width, header.height, describe(header)));
}

/// What has been told before OpenCV makes room for it.
void checkHeader(const std::string& path, const ImageHeader& header, const SizeCheck& check) {
  if (header.format == ImageFormat::none)
    throw Error(path, "cannot be decoded: expected a PNG, TIFF, EXR or JPEG image, found none");
  if (!header.damage.empty())
    throw Error(path, "cannot be decoded: " + header.damage + "; is it damaged?");
  if (header.width == 0 || header.height == 0 || header.width > kMaxSide ||
      header.height > kMaxSide) {
    throw Error(path, fmt::format("image of {} x {} pixels, expected 1 to {} each way",
                                  header.width, header.height, kMaxSide));
  }
  check(static_cast<std::int64_t>(header.width), static_cast<std::int64_t>(header.height));
  constexpr std::uint64_t kUsualTile = std::uint64_t{1} << 20;
  if (header.tile_pixels > std::max(kUsualTile, 4 * header.width * header.height))
    throw Error(path, fmt::format("image of {} x {} pixels in tiles of {} pixels; is it damaged?",
                                  header.width, header.height, header.tile_pixels));
  if (header.strip_pixels > static_cast<std::uint64_t>(kMaxPixels))
    throw Error(path, fmt::format("image of {} x {} pixels in strips of {} pixels; write it with "
                                  "fewer rows per strip",
                                  header.width, header.height, header.strip_pixels));
}

cv::Mat decodeByOpenCv(const std::string& path, const std::vector<unsigned char>& bytes,
                       const SizeCheck& check) {
  const ImageHeader header = imageHeader(bytes);
  checkHeader(path, header, check);
  if (header.format == ImageFormat::jpeg && !endsAsJpeg(bytes))
    throw Error(path, "the JPEG ends before its last pixels; is it written to its end?");
  static const auto decode = reinterpret_cast<decltype(&xviewDecodeImage)>(moduleFunction(
      "xview_codecs", "xviewDecodeImage", "images in JPEG, TIFF and EXR (PNG needs none)"));
  const QuietLibraries quiet;
  cv::Mat image;
  std::string problem;
  decode(bytes.data(), bytes.size(), image, problem);
  if (image.empty()) throw Error(path, problem);
  check(image.cols, image.rows);
  return image;
}

// ---- PFM

struct PfmHeader {
  int width = 0;
  int height = 0;
  bool little_endian = true;
};

/// Three lines: "Pf", "width height", "scale".
PfmHeader readPfmHeader(InputFile& file) {
  std::string_view line;
  if (!file.readLine(line) || line != "Pf") {
    file.fail(line == "PF" ? "expected one channel (Pf), found a colour PFM (PF)"
                           : "not a PFM file: expected Pf, found " + inQuotes(line));
  }
  PfmHeader header;
  std::vector<std::string_view> words;
  if (file.readLine(line)) words = splitWords(line);
  const auto side = [&](std::size_t i) {
    const auto value = i < words.size() ? numberFrom<std::int64_t>(words[i]) : std::nullopt;
    if (!value || *value < 1 || *value > 32768 || words.size() != 2) {
      file.failAtLine("expected width and height, 1 to 32768 each, found {}", inQuotes(line));
    }
    return static_cast<int>(*value);
  };
  header.width = side(0);
  header.height = side(1);
  if (!file.readLine(line)) file.fail("ends before the scale");
  const auto scale = numberFrom<double>(line);
  if (!scale || !std::isfinite(*scale) || *scale == 0) {
    file.failAtLine("expected a scale that is not 0, found {}", inQuotes(line));
  }
  header.little_endian = *scale < 0;
  return header;
}

}  // namespace

PngHeader checkPng(const std::string& path, const std::vector<unsigned char>& bytes) {
  if (bytes.size() < 8 || std::memcmp(bytes.data(), kSignature, 8) != 0) {
    throw Error(path, "not a PNG file: wrong signature");
  }
  PngHeader header;
  std::uint64_t packed_bytes = 0;
  for (std::size_t at = 8;;) {
    const std::string place = fmt::format("PNG damaged at byte {}: ", at);
    if (bytes.size() - at < 12) throw Error(path, place + "the file ends inside a chunk");
    const unsigned char* chunk = bytes.data() + at;
    const std::uint64_t length = boost::endian::load_big_u32(chunk);
    if (length > bytes.size() - at - 12) {
      throw Error(path, fmt::format("{}a chunk of {} bytes, only {} are left", place, length,
                                    bytes.size() - at - 12));
    }
    if (kLooksAtChecksums && libdeflate_crc32(0, chunk + 4, length + 4) !=
                                 boost::endian::load_big_u32(chunk + 8 + length)) {
      throw Error(path, place + "wrong checksum");
    }
    const std::string_view type(reinterpret_cast<const char*>(chunk) + 4, 4);
    if ((at == 8) != (type == "IHDR")) throw Error(path, place + "header missing or twice");
    if (type == "IHDR") header = parseHeader(path, chunk + 8, length);
    if (type == "IDAT") {
      packed_bytes += length;
      header.data.push_back({at + 8, static_cast<std::size_t>(length)});
    }
    if (type == "IEND") break;
    at += 12 + length;
  }
  const auto pixels = static_cast<std::uint64_t>(header.width) * header.height;
  const std::uint64_t raw_bytes = pixels * header.bits * channelsOf(header.color) / 8;
  if (raw_bytes > packed_bytes * kMaxInflation) {
    throw Error(path, fmt::format("PNG with {} bytes of data cannot hold {} x {} pixels",
                                  packed_bytes, header.width, header.height));
  }
  return header;
}

cv::Mat decodePng(const PngHeader& header, const std::vector<unsigned char>& bytes) {
  if (!isReadable(header)) return {};
  const int channels = channelsOf(header.color);
  const auto pixel_bytes = static_cast<std::size_t>(channels * header.bits / 8);
  const std::vector<Pass> passes = passesOf(header);
  std::size_t size = 0;
  for (const Pass& pass : passes)
    size += bytesOf(pass.columnsOf(header.width), pass.rowsOf(header.height), pixel_bytes);
  std::vector<Byte> rows = inflate(header, bytes, size);
  if (rows.empty()) return {};
  const int type = CV_MAKETYPE(header.bits == 8 ? CV_8U : CV_16U, channels == 2 ? 4 : channels);
  cv::Mat image(header.height, header.width, type);
  Byte* next = rows.data();
  for (const Pass& pass : passes) {
    const int columns = pass.columnsOf(header.width), height = pass.rowsOf(header.height);
    if (columns == 0 || height == 0) continue;
    cv::Mat part = header.interlaced ? cv::Mat(height, columns, type) : image;
    if (!decodePass(header, next, part)) return {};
    next += bytesOf(columns, height, pixel_bytes);
    if (header.interlaced) scatter(part, pass, image);
  }
  return image;
}

SizeCheck anySize(const std::string& path) {
  return [path](std::int64_t width, std::int64_t height) {
    if (width * height > kMaxPixels)
      throw Error(path, fmt::format("image of {} x {} pixels, expected {} million at most", width,
                                    height, kMaxPixels / 1000000));
  };
}

cv::Mat decodeImage(const std::string& path, const SizeCheck& check) {
  InputFile file(path);
  if (file.size() == 0) throw Error(path, "the file is empty, expected an image");
  try {
    std::vector<unsigned char> bytes(file.size());
    file.readBytes(bytes.data(), bytes.size());
    const bool is_png = isNamedPng(path) || imageHeader(bytes).format == ImageFormat::png;
    return is_png ? decodeSoundPng(path, bytes, check) : decodeByOpenCv(path, bytes, check);
  } catch (const std::bad_alloc&) {
    throw Error(path, "its pixels need more memory than there is");
  }
}

std::string describePixels(const cv::Mat& image) {
  static constexpr const char* kTypes[] = {"8-bit unsigned", "8-bit signed",  "16-bit unsigned",
                                           "16-bit signed",  "32-bit signed", "32-bit float",
                                           "64-bit float",   "16-bit float"};
  const int channels = image.channels();
  return fmt::format("{}, {} channel{}", kTypes[image.depth()], channels, channels == 1 ? "" : "s");
}

LabelImage channelOf(const cv::Mat& image, int channel, const std::string& path) {
  const bool fits = image.depth() == CV_8U || image.depth() == CV_16U;
  if (!fits || channel >= image.channels()) {
    throw Error(path,
                fmt::format("expected 8 or 16-bit unsigned with at least {} channels, found {}",
                            channel + 1, describePixels(image)));
  }
  cv::Mat one = image;
  if (image.channels() > 1) cv::extractChannel(image, one, channel);
  LabelImage result(image.cols, image.rows);
  cv::Mat pixels(image.rows, image.cols, CV_16U, result.pixels.data());
  one.convertTo(pixels, CV_16U);
  return result;
}

ColorTable colorTable(const LabelSet& labels) {
  ColorTable table;
  for (const auto& [id, info] : labels.classes()) {
    const auto& [red, green, blue] = info.color;
    table.emplace(std::uint32_t{red} << 16 | std::uint32_t{green} << 8 | blue,
                  static_cast<std::uint16_t>(id));
  }
  return table;
}

LabelImage labelsOfColors(const cv::Mat& image, const ColorTable& table, const std::string& path) {
  const int channels = image.channels();
  if (image.depth() != CV_8U || channels < 3) {
    throw Error(path, "expected class colours as 8-bit unsigned, 3 channels, found " +
                          describePixels(image));
  }
  LabelImage labels(image.cols, image.rows);
  for (int y = 0; y < image.rows; ++y) {
    const std::uint8_t* pixel = image.ptr<std::uint8_t>(y);  // blue, green, red
    for (int x = 0; x < image.cols; ++x, pixel += channels) {
      const auto found =
          table.find(std::uint32_t{pixel[2]} << 16 | std::uint32_t{pixel[1]} << 8 | pixel[0]);
      labels.at(x, y) = found == table.end() ? std::uint16_t{0} : found->second;
    }
  }
  return labels;
}

Image<float> readPfm(const std::string& path) {
  InputFile file(path);
  const PfmHeader header = readPfmHeader(file);
  const std::uint64_t row_bytes = std::uint64_t{4} * header.width;
  if (file.remaining() != row_bytes * header.height) {
    file.fail("expected {} bytes for {} x {} pixels, found {}", row_bytes * header.height,
              header.width, header.height, file.remaining());
  }
  Image<float> image(header.width, header.height);
  std::vector<unsigned char> row(row_bytes);
  for (int y = header.height - 1; y >= 0; --y) {
    file.readBytes(row.data(), row.size());
    if (!header.little_endian) {
      for (std::size_t i = 0; i < row.size(); i += 4) std::reverse(&row[i], &row[i] + 4);
    }
    std::memcpy(&image.at(0, y), row.data(), row.size());
  }
  return image;
}

}  // namespace xview::io
