// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "input_file.h"
#include "xview/io/cloud_files.h"

namespace xview::io {

// PCD, PLY, LAS and E57 files in one form: elements (points, vertices, edges), each a table of
// typed columns.

enum class ScalarType { i8, u8, i16, u16, i32, u32, i64, u64, f32, f64 };

std::size_t sizeOf(ScalarType type);
inline bool isInteger(ScalarType type) { return type < ScalarType::f32; }

struct Column {
  std::string name;
  ScalarType type = ScalarType::f32;
  std::uint64_t count = 1;  ///< values per row; for a list its length stands in the data
  std::optional<ScalarType> list_size;  ///< type of the length, if the column is a list
};

struct Element {
  std::string name;  ///< "point" for PCD
  std::uint64_t rows = 0;
  std::vector<Column> columns;

  bool hasLists() const;
  /// Bytes of a row in a binary file if its lists are empty; saturates at 2^64-1.
  std::uint64_t rowBytes() const;
  /// Position of the column of that name; none if there is none. Two of that name, or one that does
  /// not hold one number per row, are an error of the file.
  std::optional<std::size_t> findColumn(const std::string& column, const InputFile& file) const;
  std::string columnNames() const;  ///< "x y z label", for messages
};

enum class Encoding { ascii, little_endian, big_endian, compressed, packets };

/// A parsed header; the file stands at the first byte of the body.
struct FileLayout {
  std::string format;  ///< "PCD ascii", "PLY binary_little_endian", …
  Encoding encoding = Encoding::ascii;
  std::vector<Element> elements;
  std::vector<std::string> comments;               ///< of the header, words joined by one blank
  Eigen::Array3d scale = Eigen::Array3d::Ones();   ///< position = offset + scale * x y z
  Eigen::Array3d offset = Eigen::Array3d::Zero();  ///< [m]
  Eigen::Array3d unit_m = Eigen::Array3d::Ones();  ///< of the file; scale and offset are metres
  std::uint32_t label_bits = ~std::uint32_t{0};    ///< of the label column that are the class
  std::string georeference;                ///< coordinate system as the file says it; empty = none
  std::vector<std::string> notes;          ///< what is odd about the file, in sentences
  std::size_t setups = 1;                  ///< scans of an E57 that are read
  std::vector<std::string> of_some_scans;  ///< fields of an E57 that not all of them have
  bool ends_with_rows = true;  ///< false: something that is not read may follow the last row

  const Element* findElement(const std::string& name) const;
};

/// Reads the header of a PCD file up to its DATA line: one element "point". Entries may come in any
/// order; VERSION, COUNT, VIEWPOINT, and either POINTS or WIDTH and HEIGHT may be absent.
FileLayout readPcdHeader(InputFile& file);
/// Reads the header of a PLY file up to end_header: all its elements in order.
FileLayout readPlyHeader(InputFile& file);

/// Reads the header of a LAS file, and its variable records: one element "point" with the columns
/// of its point format; what a point has beyond them is "extra_bytes".
FileLayout readLasHeader(InputFile& file);

/// Reads what the XML of an E57 file says: one element "point" with x, y and z of all scans in the
/// frame of the file, and what else the points of the first scan have.
FileLayout readE57Header(InputFile& file);

/// The header of a cloud of any kind, by the ending of its name, checked against the size of the
/// file. Throws Error.
FileLayout readCloudLayout(InputFile& file);
/// Its element "point" or "vertex". Throws Error if there is none.
const Element& pointsIn(const FileLayout& layout, const InputFile& file);

/// Throws Error if the rest of the file cannot hold the rows that the header announces. In 64 bit
/// and before anything is allocated, so that a header of 200 bytes cannot demand gigabytes.
void checkSize(const InputFile& file, const FileLayout& layout);

// Clouds and graphs name their classes themselves, in comments of their header that other programs
// skip: `xview class ID ROLE KIND RED GREEN BLUE NAME`, after one line `xview label_set NAME`.

/// The lines, each after `mark` ("# " in PCD, "comment " in PLY) and ended; none for a generic set,
/// whose names say nothing.
std::string classComments(const LabelSet& labels, const std::string& mark);
/// The header of a binary PCD of such columns; `comments` are whole lines, marked and ended. A
/// column "rgb" is a float, as PCL packs colours.
std::string pcdHeader(const std::vector<Column>& columns, std::uint64_t points,
                      const std::string& comments);
/// The same of a little-endian PLY.
std::string plyHeader(const std::vector<Column>& columns, std::uint64_t points,
                      const std::string& comments);

/// Throws Error if a header is longer than a reader takes it, because of such lines.
void requireReadable(const std::string& path, const std::string& header);
/// The classes that the comments of a header name, or those of the shipped label set that one of
/// them names; none if there is neither. Throws Error if one of them is not as written by
/// classComments.
std::optional<LabelSet> readClassComments(const std::vector<std::string>& comments,
                                          const InputFile& file);

/// Where a row stands, for messages: "path:line: what" in text, "path: point 17: what" in binary
/// files (points from 0).
struct RowPlace {
  const InputFile& file;
  const Element& element;
  bool text = false;
  std::uint64_t row = 0;

  [[noreturn]] void fail(const std::string& what) const;
  template <class Value, class... Values>
  [[noreturn]] void fail(fmt::format_string<Value, Values...> what, Value&& value,
                         Values&&... values) const {
    fail(fmt::format(what, std::forward<Value>(value), std::forward<Values>(values)...));
  }
};

/// Is called for every row with the values of the chosen columns, in the order of the choice.
using RowVisitor = std::function<void(const double* values, const RowPlace& place)>;

/// Reads the rows of one element; the file stands at the first and is left behind the last. The
/// chosen columns must be no lists and have one value per row; everything else is skipped (in text:
/// must be numbers). Integers beyond 2^53 are rounded, which no coordinate and no id can notice.
/// Throws Error.
void readRows(InputFile& file, const FileLayout& layout, const Element& element,
              const std::vector<std::size_t>& columns, const RowVisitor& visit);

/// The rows of an E57 file as readRows() visits those of others; x, y and z of a point that was not
/// measured are NaN. Throws Error, also if the sum of a page is another.
void readE57Rows(InputFile& file, const Element& points, const std::vector<std::size_t>& columns,
                 const RowVisitor& visit);

/// A table that is in memory already, in lines of rows that may have something between them.
struct StoredRows {
  const char* bytes = nullptr;         ///< of the first row
  std::vector<std::uint64_t> offsets;  ///< of each column in a row
  std::uint64_t row_bytes = 0;         ///< from a row to the next
  std::uint64_t line_rows = 0;         ///< at least 1
  std::uint64_t line_bytes = 0;        ///< from a line to the next
  bool big_endian = false;
};
/// Its rows as readRows() would visit them; nothing is checked.
void readStoredRows(const InputFile& file, const Element& element, const StoredRows& rows,
                    const std::vector<std::size_t>& columns, const RowVisitor& visit);
/// The cloud of such a table. `file` is what errors are said of.
LabelledCloud readStoredCloud(const InputFile& file, const Element& points, const StoredRows& rows,
                              const CloudFields& fields);

/// The rows of one table of a file, up to its end; all others are read over. Throws Error.
void readTable(InputFile& file, const FileLayout& layout, const Element& table,
               const std::vector<std::size_t>& columns, const RowVisitor& visit);

/// Whether the points of a scan (readKittiScan) have five numbers.
bool hasRings(const std::string& bin_path);

/// The largest coordinate, but for its sign, of the first point of a cloud, if they are float32 in
/// a binary file; else 0. No more is read.
float largestFloatCoordinate(const std::string& path);

/// How many points of a LAS file were classified, and how many have a class that tells things
/// apart: none of ground, of noise and of overlapping flight lines.
struct ClassifiedPoints {
  std::uint64_t classified = 0, telling = 0, all = 0;
  bool hasClassified(double share) const { return isShare(classified, share); }
  bool hasTelling(double share) const { return isShare(telling, share); }

 private:
  bool isShare(std::uint64_t part, double share) const {
    return static_cast<double>(part) >= share * static_cast<double>(all);
  }
};
/// Reads no farther than to where `isEnough`.
ClassifiedPoints classifiedPoints(const std::string& path,
                                  const std::function<bool(const ClassifiedPoints&)>& isEnough);

/// Throws Error if something other than blanks, blank lines or a little padding with zeros follows
/// the last row.
void requireEnd(InputFile& file, const FileLayout& layout);

/// Columns of a point element that hold the label and the instance.
struct IdColumns {
  std::optional<std::size_t> label, instance;
};

/// The columns that were asked for, else the first of the well-known names. Throws Error if one
/// that was asked for is absent or is not one number per point.
IdColumns findIdColumns(const Element& points, const CloudFields& fields, const InputFile& file);
/// Whether a field of this name, in whatever case, is looked for as label or instance.
bool namesId(const std::string& name);

/// The column with the standard deviations of the positions [m], if there is one.
std::optional<std::size_t> findSigmaColumn(const Element& points, const InputFile& file);

/// The columns that are read of an element with points: first x, y and z, then those added.
class ChosenColumns {
 public:
  using Slot = std::optional<std::size_t>;  ///< position among the chosen; none: not in the file

  /// Throws Error if x, y or z (or X, Y, Z) is missing.
  ChosenColumns(const Element& points, const InputFile& file);
  Slot add(const std::optional<std::size_t>& column);

  const std::vector<std::size_t>& all() const { return columns_; }
  const Column& column(std::size_t slot) const { return element_.columns[columns_[slot]]; }
  /// A class or instance id from a number of any type. Negative numbers, and the largest of 32 and
  /// 64 bit, which is how -1 looks when it was stored unsigned, and NaN are 0: none. Fractions and
  /// numbers beyond 32 bit are errors.
  std::uint32_t id(const Slot& slot, const double* values, const RowPlace& place,
                   std::uint32_t absent = 0) const;
  /// A standard deviation [m], 0 if there is none. What is not finite, or negative, is an error.
  float sigma(const Slot& slot, const double* values, const RowPlace& place) const;

 private:
  const Element& element_;
  std::vector<std::size_t> columns_;
};

}  // namespace xview::io
