// SPDX-License-Identifier: BSD-3-Clause
#include <bzlib.h>
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <functional>
#include <memory>

#include "bag_file.h"

namespace xview::io {
namespace {

constexpr std::size_t kStep = std::size_t{1} << 20;  ///< room for more [bytes]

/// Unpacks from `in` to `out`, shortens both to what is left, and says whether it goes on; false if
/// the stream has ended or is damaged.
struct Piece {
  const char* in;
  std::size_t in_left;
  char* out;
  std::size_t out_left;
};
using Unpack = std::function<bool(Piece& piece)>;

Unpack byZstd() {
  const std::shared_ptr<ZSTD_DCtx> context(ZSTD_createDCtx(), ZSTD_freeDCtx);
  return [context](Piece& piece) {
    ZSTD_inBuffer in{piece.in, piece.in_left, 0};
    ZSTD_outBuffer out{piece.out, piece.out_left, 0};
    const std::size_t left = ZSTD_decompressStream(context.get(), &out, &in);
    piece = {piece.in + in.pos, piece.in_left - in.pos, piece.out + out.pos,
             piece.out_left - out.pos};
    return left != 0 && !ZSTD_isError(left);
  };
}

Unpack byLz4() {
  LZ4F_dctx* made = nullptr;
  LZ4F_createDecompressionContext(&made, LZ4F_VERSION);
  const std::shared_ptr<LZ4F_dctx> context(made, LZ4F_freeDecompressionContext);
  return [context](Piece& piece) {
    std::size_t in = piece.in_left, out = piece.out_left;
    const std::size_t left =
        LZ4F_decompress(context.get(), piece.out, &out, piece.in, &in, nullptr);
    piece = {piece.in + in, piece.in_left - in, piece.out + out, piece.out_left - out};
    return left != 0 && !LZ4F_isError(left);
  };
}

Unpack byBzip2() {
  const std::shared_ptr<bz_stream> stream(new bz_stream(), [](bz_stream* done) {
    BZ2_bzDecompressEnd(done);
    delete done;
  });
  BZ2_bzDecompressInit(stream.get(), 0, 0);
  return [stream](Piece& piece) {
    stream->next_in = const_cast<char*>(piece.in);
    stream->avail_in = static_cast<unsigned>(std::min(piece.in_left, kLargestChunk));
    stream->next_out = piece.out;
    stream->avail_out = static_cast<unsigned>(piece.out_left);
    const std::size_t in = stream->avail_in;
    const int state = BZ2_bzDecompress(stream.get());
    piece = {stream->next_in, piece.in_left - (in - stream->avail_in), stream->next_out,
             stream->avail_out};
    return state == BZ_OK;
  };
}

Unpack unpackerOf(const InputFile& file, const std::string& compression) {
  if (compression == "zstd") return byZstd();
  if (compression == "lz4") return byLz4();
  if (compression == "bz2") return byBzip2();
  file.fail("expected chunks of zstd, lz4, bz2 or none, found {}", io::inQuotes(compression));
}

}  // namespace

std::string unpacked(const InputFile& file, const std::string& compression,
                     const std::string& packed, std::uint64_t bytes, std::uint64_t most_bytes) {
  const Unpack unpack = unpackerOf(file, compression);
  const std::uint64_t most = std::min(kLargestChunk, mostUnpacked(file));
  if (bytes > most) file.fail("a chunk of {} bytes, expected {} at most", bytes, most);
  const bool is_whole = most_bytes >= bytes;
  // One byte more than it should become shows that it becomes more.
  const std::uint64_t end = is_whole ? bytes + 1 : most_bytes;
  std::string out;
  std::size_t done = 0;
  Piece piece{packed.data(), packed.size(), nullptr, 0};
  for (bool goes_on = true; goes_on && done < end;) {
    const std::size_t room = std::max(kStep, out.size());
    if (done == out.size()) out.resize(std::min<std::uint64_t>(end, out.size() + room));
    const std::size_t in_before = piece.in_left;
    piece.out = out.data() + done;
    piece.out_left = out.size() - done;
    goes_on = unpack(piece);
    const std::size_t grown = out.size() - done - piece.out_left;
    done += grown;
    if (grown == 0 && piece.in_left == in_before) break;
  }
  if (is_whole && done != bytes)
    file.fail("a chunk of {} unpacks to {} bytes{}, expected {}", compression, done,
              done > bytes ? " and more" : "", bytes);
  out.resize(done);
  return out;
}

bool isPackedMessage(const std::string& bytes) {
  return bytes.compare(0, 4, "\x28\xB5\x2F\xFD") == 0;
}

std::string unpackedMessage(const InputFile& file, const std::string& packed,
                            std::uint64_t most_bytes) {
  return unpacked(file, "zstd", packed, ZSTD_getFrameContentSize(packed.data(), packed.size()),
                  most_bytes);
}

}  // namespace xview::io
