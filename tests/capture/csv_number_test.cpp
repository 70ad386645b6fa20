#include "capture/csv_number.h"

#include <bit>
#include <cmath>
#include <cstdio>

#include "core/random.h"

namespace vildar {
namespace {

double reference(const std::string& text) {
  double value = 0.0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

/// True where the fast reader took the text; then its value must be that of the library, to the
/// last bit.
bool agrees_if_taken(const std::string& text) {
  const std::string ended = text + ",";
  const char* at = ended.data();
  double value = 0.0;
  if (!read_plain_number(at, value)) return false;
  EXPECT_EQ(at, ended.data() + text.size()) << text;
  EXPECT_EQ(std::bit_cast<std::uint64_t>(value), std::bit_cast<std::uint64_t>(reference(text)))
      << text;
  return true;
}

TEST(CsvNumber, FastReaderIsBitExact) {
  Random random(3);
  int taken = 0;
  constexpr int kTrials = 20000;
  for (int trial = 0; trial < kTrials; ++trial) {
    char text[64];
    const int digits = static_cast<int>(random.uniform(0.0, 20.0));
    const double value = random.normal() * std::pow(10.0, random.uniform(-25.0, 12.0));
    if (trial % 3 == 0)
      std::snprintf(text, sizeof text, "%.*f", digits, value);
    else
      std::snprintf(text, sizeof text, trial % 3 == 1 ? "%.*e" : "%.*G", digits, value);
    taken += agrees_if_taken(text) ? 1 : 0;
  }
  EXPECT_GT(taken, kTrials / 3) << "the fast reader must take ordinary numbers";
  for (const char* text : {"0", "-0", "1", "12.5", "-0.0001", "9007199254740992", ".5", "5.",
                           "1e22", "1E-22", "3.25e+2"})
    EXPECT_TRUE(agrees_if_taken(text)) << text;
}

TEST(CsvNumber, WhatIsNoPlainNumberIsLeftToTheSlowReader) {
  for (const char* text : {"", "-", ".", "e5", "1e", "1e+", "nan", "inf", "12345678901234567890123",
                           "1e400", "1e99999999999"})
    EXPECT_FALSE(agrees_if_taken(text)) << text;
}

TEST(CsvNumber, SlowReaderTellsEmptyFromUnreadable) {
  for (const char* text :
       {"", "  ", "\"\"", "nan", "NaN", "inf", "-Infinity", "null", "N/A", "1e400"})
    EXPECT_TRUE(std::isnan(number_in_cell(text).value())) << text;
  for (const char* text : {"abc", "1.2.3", "0x10", "1,5", "--1", "+-1", "12 34", "1e"})
    EXPECT_FALSE(number_in_cell(text)) << text;
  EXPECT_EQ(number_in_cell(" +1.5\t"), 1.5);
  EXPECT_EQ(number_in_cell("\"-2e-3\""), -2e-3);
}

}  // namespace
}  // namespace vildar
