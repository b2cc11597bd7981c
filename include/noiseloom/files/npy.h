// NumPy's .npy files: reads plain numbers, writes float32 and int64.
//
// Format: "\x93NUMPY", version, length of the header, a Python dict (descr, fortran_order, shape), the raw array
// [NumPy Enhancement Proposal 1].
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "noiseloom/core/number_type.h"

namespace noiseloom {

struct NpyArray {
  std::vector<std::int64_t> shape;  // last dimension varies fastest; empty for a single number
  std::vector<double> values;       // every accepted type fits without loss; in C order, whatever the file's
  NumberType type;                  // as stored
};

// Reads floats of 16, 32 and 64 bits and integers of 8 to 64 bits, little or big endian, C or Fortran order, format 1
// to 3. UserError, naming the path and what was found, for anything else: another type, integers beyond 2^53, a header
// that is none, too few or too many bytes. NaN and inf are passed on. Nothing is allocated for values that the file is
// too short to hold.
NpyArray read_npy(const std::string& path);
// The shape alone, without the values; throws as read_npy does for what the header says wrong, and for too few or too
// many bytes.
std::vector<std::int64_t> read_npy_shape(const std::string& path);

// "(64, 128, 3)", as NumPy writes it.
std::string npy_shape_text(std::span<const std::int64_t> shape);

// What stands before the values of an array of that shape: for writers that stream.
std::string npy_float32_header(std::span<const std::int64_t> shape);
std::string npy_int64_header(std::span<const std::int64_t> shape);

// Requires as many values as the shape says. EnvironmentError if the file cannot be written.
void write_npy(const std::string& path, std::span<const std::int64_t> shape, std::span<const float> values);

}  // namespace noiseloom
