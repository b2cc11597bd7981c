// Datasets of HDF5 files that anybody made, read as plain numbers. They are named FILE:/GROUP/DATASET.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "noiseloom/core/number_type.h"

namespace noiseloom {

struct Hdf5Array {
  std::vector<std::int64_t> shape;  // last dimension varies fastest
  std::vector<double> values;
  NumberType type;  // as stored
};

struct DatasetName {
  std::string file;
  std::string dataset;  // absolute: "/group/name"
};
// The two parts of FILE:/DATASET; none where the text is not that, or no such file is there.
std::optional<DatasetName> split_dataset_name(const std::string& text);

// True where the file holds HDF5 (its signature at the start, or behind a user block).
bool is_hdf5(const std::string& path);

// `name` is FILE:/DATASET; FILE alone will do where it holds one dataset of numbers in two or more dimensions. Floats
// and integers of 8 to 64 bits in any byte order, stored in the file itself. Throws UserError, listing the datasets
// that there are, where the name says none of them, and for what is no array of numbers or claims more than the file
// can hold.
std::vector<std::int64_t> hdf5_array_shape(const std::string& name);
Hdf5Array read_hdf5_array(const std::string& name);

}  // namespace noiseloom
