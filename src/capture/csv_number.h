#pragma once

#include <array>
#include <charconv>
#include <cstdint>
#include <optional>
#include <string_view>

namespace vildar {

/// Reads the decimal number at `cell` and moves it past the number. The text must end in a
/// character that is no part of a number (a comma, a line end). The value is that of
/// std::from_chars to the last bit. False, with `cell` anywhere, where there is no plain number, or
/// one that needs the general reader: more than 19 digits, a mantissa above 2^53, a power of ten
/// beyond 22.
///
/// A mantissa and a power of ten that a double holds exactly give, by one division or
/// multiplication, the nearest double (Clinger 1990).
inline bool read_plain_number(const char*& cell, double& value) {
  constexpr int kLargestExactPower = 22;
  constexpr std::uint64_t kLargestExactMantissa = std::uint64_t{1} << 53;
  static constexpr std::array<double, kLargestExactPower + 1> kPowers{
      1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
      1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
  const auto digit = [](char c) {
    return static_cast<unsigned>(static_cast<unsigned char>(c)) - '0';
  };
  const char* at = cell;
  const bool negative = *at == '-';
  if (negative) ++at;
  std::uint64_t mantissa = 0;
  const char* first = at;
  for (unsigned d; (d = digit(*at)) < 10; ++at) mantissa = mantissa * 10 + d;
  std::ptrdiff_t digits = at - first;
  std::ptrdiff_t power = 0;
  if (*at == '.') {
    const char* point = at++;
    for (unsigned d; (d = digit(*at)) < 10; ++at) mantissa = mantissa * 10 + d;
    power = -(at - point - 1);
    digits -= power;
  }
  if (digits == 0 || digits > 19 || mantissa > kLargestExactMantissa) return false;
  if (*at == 'e' || *at == 'E') {
    ++at;
    const bool minus = *at == '-';
    if (minus || *at == '+') ++at;
    int exponent = 0;
    const char* first_of_exponent = at;
    for (unsigned d; (d = digit(*at)) < 10 && exponent < 1000; ++at)
      exponent = exponent * 10 + static_cast<int>(d);
    if (at == first_of_exponent) return false;
    power += minus ? -exponent : exponent;
  }
  if (power < -kLargestExactPower || power > kLargestExactPower) return false;
  const auto exact = static_cast<double>(mantissa);
  const double magnitude = power < 0 ? exact / kPowers[static_cast<std::size_t>(-power)]
                                     : exact * kPowers[static_cast<std::size_t>(power)];
  value = negative ? -magnitude : magnitude;
  cell = at;
  return true;
}

/// A whole cell, blanks around it and a pair of quotes allowed. NaN for an empty cell, `nan`,
/// `inf`, or a number beyond the range of a double; nullopt for anything else that is not a number.
std::optional<double> number_in_cell(std::string_view cell);

}  // namespace vildar
