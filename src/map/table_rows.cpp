// SPDX-License-Identifier: BSD-3-Clause
#include "table_rows.h"

#include <SQLiteCpp/Column.h>

#include <cmath>
#include <cstring>

namespace xview {
namespace {

std::string insertStatement(const std::string& table, int columns) {
  std::string sql = "INSERT INTO " + table + " VALUES(?";
  for (int i = 1; i < columns; ++i) sql += ",?";
  return sql + ")";
}

}  // namespace

void ContentHash::add(double value) {
  std::uint64_t bits = 0;
  std::memcpy(&bits, &value, sizeof bits);
  mix(bits);
}

void ContentHash::add(const void* data, std::size_t size) {
  mix(size);
  const auto* bytes = static_cast<const std::uint8_t*>(data);
  for (; size >= 8; size -= 8, bytes += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes, 8);
    mix(word);
  }
  for (; size > 0; --size) mix(*bytes++);
}

RowWriter::RowWriter(SQLite::Database& database, const std::string& table, int columns)
    : statement_(database, insertStatement(table, columns)) {}

void RowWriter::bindInteger(std::int64_t value) {
  statement_.bind(next_++, value);
  hash_.add(value);
}

void RowWriter::operator()(double value) {
  // SQLite knows neither NaN, which becomes NULL, nor the sign of zero.
  value = std::isnan(value) ? std::numeric_limits<double>::quiet_NaN() : value + 0.0;
  statement_.bind(next_++, value);
  hash_.add(value);
}

void RowWriter::operator()(const std::string& text) {
  statement_.bind(next_++, text);
  hash_.add(text.data(), text.size());
}

void RowWriter::operator()(const Bytes& blob) {
  statement_.bind(next_++, blob.data(), static_cast<int>(blob.size()));
  hash_.add(blob.data(), blob.size());
}

void RowWriter::endRow() {
  statement_.exec();
  statement_.reset();
  next_ = 1;
}

RowReader::RowReader(SQLite::Database& database, const std::string& table)
    : table_(table), statement_(database, "SELECT * FROM " + table + " ORDER BY id") {}

bool RowReader::nextRow() {
  next_ = 0;
  return statement_.executeStep();
}

std::int64_t RowReader::integer() {
  const std::int64_t value = statement_.getColumn(next_++).getInt64();
  hash_.add(value);
  return value;
}

void RowReader::operator()(double& value) {
  const SQLite::Column column = statement_.getColumn(next_++);
  value = column.getDouble();
  if (value == 0 && column.isNull()) value = std::numeric_limits<double>::quiet_NaN();
  hash_.add(value);
}

void RowReader::operator()(std::string& text) {
  text = statement_.getColumn(next_++).getString();
  hash_.add(text.data(), text.size());
}

void RowReader::operator()(Bytes& blob) {
  const SQLite::Column column = statement_.getColumn(next_++);
  const auto* data = static_cast<const std::uint8_t*>(column.getBlob());
  blob.assign(data, data + column.getBytes());
  hash_.add(blob.data(), blob.size());
}

void RowReader::verify(std::int64_t expected_hash) const {
  if (hash_.value() != expected_hash) throw Damage("table " + table_ + " is not as it was written");
}

}  // namespace xview
