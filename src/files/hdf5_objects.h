// Groups, datasets, attributes and texts of a run file: each stored without times, contiguous, in little-endian types.
//
// Objects are named by absolute paths; messages name the file with them. Texts are fixed-length UTF-8, padded with
// zeros: a text of variable length would lie in a heap that is shared between objects. Texts of variable length are
// read, as other programs write them.
//
// What is read is checked for its kind, and for a size that the file can hold, before memory is taken. Only calls that
// HDF5 1.10, 1.12 and 1.14 have in the same form are used.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "files/hdf5_handle.h"
#include "noiseloom/files/run_file.h"

namespace noiseloom::hdf5 {

struct Location {
  hid_t file;
  std::string name;  // of the file, for messages
};

Handle group_creation_list(bool keep_link_order);

void create_group(const Location& at, const std::string& path, bool keep_link_order = false);
// Creates the groups above `path` that are still missing.
void create_parents(const Location& at, const std::string& path);
// With its place in the file fixed at once and no fill values written.
Handle create_dataset(const Location& at, const std::string& path, hid_t type, const std::vector<hsize_t>& dimensions);
void write_numbers(const Location& at, const std::string& path, const std::vector<double>& values);
void write_array(const Location& at, const std::string& path, const InputArray& array);
void write_text(const Location& at, const std::string& path, const std::string& text);
void write_attribute(const Location& at, const std::string& path, const std::string& key, const Attribute& value);
void write_attribute(const Location& at, const std::string& path, const std::string& key,
                     const std::vector<std::int64_t>& values);
// The dimension labels of HDF5's dimension scale convention, which h5py shows as dims[i].label.
void write_dimension_labels(const Location& at, hid_t dataset, const std::vector<std::string>& labels);

Handle open_dataset(const Location& at, const std::string& path);
std::vector<hsize_t> dimensions_of(const Location& at, hid_t dataset);
// Throws UserError where a dataset claims more data than the whole file can hold, so that no memory is taken for it.
void check_claim(const Location& at, const std::string& path, hid_t dataset);
std::vector<double> read_numbers(const Location& at, const std::string& path);
// float32 or float64, in whatever shape.
InputArray read_array(const Location& at, const std::string& path);
std::vector<std::uint64_t> read_words(const Location& at, const std::string& path);
std::string read_text(const Location& at, const std::string& path);
// The attributes of an object that are one number or text.
std::map<std::string, Attribute> read_attributes(const Location& at, const std::string& path);
std::string read_text_attribute(const Location& at, const std::string& path, const std::string& key);
std::vector<std::int64_t> read_integers(const Location& at, const std::string& path, const std::string& key);
bool exists(const Location& at, const std::string& path);
// Names in a group, in the order in which they were made where the group knows it.
std::vector<std::string> links_in_order(const Location& at, const std::string& path);

}  // namespace noiseloom::hdf5
