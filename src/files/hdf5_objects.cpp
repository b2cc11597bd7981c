#include "files/hdf5_objects.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace noiseloom::hdf5 {
namespace {

std::string doing(const Location& at, const char* what, const std::string& path) {
  return at.name + ": cannot " + what + " " + path;
}

Handle space_of(const Location& at, const std::vector<hsize_t>& dimensions) {
  return Handle(dimensions.empty() ? H5Screate(H5S_SCALAR)
                                   : H5Screate_simple(static_cast<int>(dimensions.size()), dimensions.data(), nullptr),
                H5Sclose, doing(at, "make", "a data space"));
}

Handle text_type(const Location& at, std::size_t length) {
  const std::string what = doing(at, "make", "a text type");
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose, what);
  checked(H5Tset_size(type.id(), std::max<std::size_t>(length, 1)), what);  // HDF5 knows no text of length 0
  checked(H5Tset_cset(type.id(), H5T_CSET_UTF8), what);
  checked(H5Tset_strpad(type.id(), H5T_STR_NULLPAD), what);
  return type;
}

Handle open_object(const Location& at, const std::string& path) {
  return Handle(H5Oopen(at.file, path.c_str(), H5P_DEFAULT), H5Oclose, doing(at, "open", path));
}

void write_attribute_bytes(const Location& at, const std::string& path, const std::string& key, hid_t stored_type,
                           hid_t memory_type, const std::vector<hsize_t>& dimensions, const void* bytes) {
  const std::string what = doing(at, "write attribute", path + "/@" + key);
  const Handle object = open_object(at, path);
  const Handle space = space_of(at, dimensions);
  Handle attribute(H5Acreate2(object.id(), key.c_str(), stored_type, space.id(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
                   what);
  checked(H5Awrite(attribute.id(), memory_type, bytes), what);
  attribute.close(what);
}

// A text of `type`, without its padding. `read` fills the bytes of one value. Noiseloom's own texts have a fixed
// length; h5py writes them at any length, which HDF5 hands out as a pointer.
template <class Read>
std::string text_value(hid_t type, const std::string& what, Read read) {
  if (checked(H5Tis_variable_str(type), what) > 0) {
    char* bytes = nullptr;
    read(&bytes);
    const std::string text = bytes ? bytes : "";
    H5free_memory(bytes);
    return text;
  }
  std::string text(H5Tget_size(type), '\0');
  read(text.data());
  text.resize(text.find_last_not_of('\0') + 1);
  return text;
}

std::size_t num_elements(hid_t attribute, const std::string& what) {
  const Handle space(H5Aget_space(attribute), H5Sclose, what);
  return static_cast<std::size_t>(checked(H5Sget_simple_extent_npoints(space.id()), what));
}

// Nothing for an attribute that is not one number or text: such are not noiseloom's.
std::optional<Attribute> read_one(hid_t attribute, const std::string& what) {
  if (num_elements(attribute, what) != 1) return std::nullopt;
  const Handle type(H5Aget_type(attribute), H5Tclose, what);
  switch (H5Tget_class(type.id())) {
    case H5T_INTEGER: {
      std::int64_t value = 0;
      checked(H5Aread(attribute, H5T_NATIVE_INT64, &value), what);
      return value;
    }
    case H5T_FLOAT: {
      double value = 0;
      checked(H5Aread(attribute, H5T_NATIVE_DOUBLE, &value), what);
      return value;
    }
    case H5T_STRING:
      return text_value(type.id(), what, [&](void* bytes) { checked(H5Aread(attribute, type.id(), bytes), what); });
    default:
      return std::nullopt;
  }
}

herr_t collect_name(hid_t, const char* name, const H5A_info_t*, void* names) {
  static_cast<std::vector<std::string>*>(names)->emplace_back(name);
  return 0;
}

}  // namespace

Handle group_creation_list(bool keep_link_order) {
  const std::string what = "cannot make a group creation list";
  Handle list(H5Pcreate(H5P_GROUP_CREATE), H5Pclose, what);
  checked(H5Pset_obj_track_times(list.id(), false), what);
  if (keep_link_order) {
    checked(H5Pset_link_creation_order(list.id(), H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED), what);
  }
  return list;
}

void create_group(const Location& at, const std::string& path, bool keep_link_order) {
  const std::string what = doing(at, "create group", path);
  const Handle list = group_creation_list(keep_link_order);
  Handle group(H5Gcreate2(at.file, path.c_str(), H5P_DEFAULT, list.id(), H5P_DEFAULT), H5Gclose, what);
  group.close(what);
}

void create_parents(const Location& at, const std::string& path) {
  for (std::size_t slash = path.find('/', 1); slash != std::string::npos; slash = path.find('/', slash + 1)) {
    const std::string parent = path.substr(0, slash);
    if (!exists(at, parent)) create_group(at, parent);
  }
}

Handle create_dataset(const Location& at, const std::string& path, hid_t type, const std::vector<hsize_t>& dimensions) {
  const std::string what = doing(at, "create", path);
  const Handle list(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, what);
  checked(H5Pset_obj_track_times(list.id(), false), what);
  checked(H5Pset_layout(list.id(), H5D_CONTIGUOUS), what);
  checked(H5Pset_alloc_time(list.id(), H5D_ALLOC_TIME_EARLY), what);
  checked(H5Pset_fill_time(list.id(), H5D_FILL_TIME_NEVER), what);
  const Handle space = space_of(at, dimensions);
  return Handle(H5Dcreate2(at.file, path.c_str(), type, space.id(), H5P_DEFAULT, list.id(), H5P_DEFAULT), H5Dclose,
                what);
}

void write_numbers(const Location& at, const std::string& path, const std::vector<double>& values) {
  const std::string what = doing(at, "write", path);
  Handle dataset = create_dataset(at, path, H5T_IEEE_F64LE, {values.size()});
  checked(H5Dwrite(dataset.id(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), what);
  dataset.close(what);
}

void write_array(const Location& at, const std::string& path, const InputArray& array) {
  const std::string what = doing(at, "write", path);
  const bool is_float = std::holds_alternative<SharedValues<float>>(array.values);
  const std::vector<hsize_t> dimensions(array.shape.begin(), array.shape.end());
  Handle dataset = create_dataset(at, path, is_float ? H5T_IEEE_F32LE : H5T_IEEE_F64LE, dimensions);
  const void* const values = std::visit([](const auto& held) -> const void* { return held.data(); }, array.values);
  checked(
      H5Dwrite(dataset.id(), is_float ? H5T_NATIVE_FLOAT : H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values),
      what);
  dataset.close(what);
}

void write_text(const Location& at, const std::string& path, const std::string& text) {
  const std::string what = doing(at, "write", path);
  const Handle type = text_type(at, text.size());
  Handle dataset = create_dataset(at, path, type.id(), {});
  checked(H5Dwrite(dataset.id(), type.id(), H5S_ALL, H5S_ALL, H5P_DEFAULT, text.c_str()), what);
  dataset.close(what);
}

void write_attribute(const Location& at, const std::string& path, const std::string& key, const Attribute& value) {
  if (const auto* integer = std::get_if<std::int64_t>(&value)) {
    write_attribute_bytes(at, path, key, H5T_STD_I64LE, H5T_NATIVE_INT64, {}, integer);
  } else if (const auto* number = std::get_if<double>(&value)) {
    write_attribute_bytes(at, path, key, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, {}, number);
  } else {
    const std::string& text = std::get<std::string>(value);
    const Handle type = text_type(at, text.size());
    write_attribute_bytes(at, path, key, type.id(), type.id(), {}, text.c_str());
  }
}

void write_attribute(const Location& at, const std::string& path, const std::string& key,
                     const std::vector<std::int64_t>& values) {
  write_attribute_bytes(at, path, key, H5T_STD_I64LE, H5T_NATIVE_INT64, {values.size()}, values.data());
}

void write_dimension_labels(const Location& at, hid_t dataset, const std::vector<std::string>& labels) {
  const std::string what = doing(at, "write", "dimension labels");
  std::vector<const char*> texts;
  for (const std::string& label : labels) texts.push_back(label.c_str());
  const Handle type(H5Tcopy(H5T_C_S1), H5Tclose, what);
  checked(H5Tset_size(type.id(), H5T_VARIABLE), what);
  const Handle space = space_of(at, {labels.size()});
  Handle attribute(H5Acreate2(dataset, "DIMENSION_LABELS", type.id(), space.id(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
                   what);
  checked(H5Awrite(attribute.id(), type.id(), texts.data()), what);
  attribute.close(what);
}

Handle open_dataset(const Location& at, const std::string& path) {
  return Handle(H5Dopen2(at.file, path.c_str(), H5P_DEFAULT), H5Dclose, doing(at, "open", path));
}

std::vector<hsize_t> dimensions_of(const Location& at, hid_t dataset) {
  const std::string what = doing(at, "read", "the dimensions of a dataset");
  const Handle space(H5Dget_space(dataset), H5Sclose, what);
  std::vector<hsize_t> dimensions(static_cast<std::size_t>(checked(H5Sget_simple_extent_ndims(space.id()), what)));
  checked(H5Sget_simple_extent_dims(space.id(), dimensions.data(), nullptr), what);
  return dimensions;
}

void check_claim(const Location& at, const std::string& path, hid_t dataset) {
  const std::string what = doing(at, "read", path);
  hsize_t file_bytes = 0;
  checked(H5Fget_filesize(at.file, &file_bytes), what);
  // Deflate makes at most 1032 bytes of one; a little for what is stored as a fill value.
  const hsize_t most = file_bytes < (std::uint64_t{1} << 52) ? 1032 * file_bytes : file_bytes;
  const Handle type(H5Dget_type(dataset), H5Tclose, what);
  hsize_t bytes = H5Tget_size(type.id());
  for (const hsize_t size : dimensions_of(at, dataset)) {
    if (size > 0 && bytes > most / size) {
      throw UserError(at.name, path + " claims more data than a file of this size can hold");
    }
    bytes *= size;
  }
  if (bytes > most) throw UserError(at.name, path + " claims more data than a file of this size can hold");
}

namespace {

// All values of a dataset, converted to `memory_type`.
template <class T>
std::vector<T> read_values(const Location& at, const std::string& path, hid_t memory_type) {
  const Handle dataset = open_dataset(at, path);
  check_claim(at, path, dataset.id());
  std::size_t count = 1;
  for (const hsize_t size : dimensions_of(at, dataset.id())) count *= size;
  std::vector<T> values(count);
  checked(H5Dread(dataset.id(), memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), doing(at, "read", path));
  return values;
}

}  // namespace

std::vector<double> read_numbers(const Location& at, const std::string& path) {
  return read_values<double>(at, path, H5T_NATIVE_DOUBLE);
}

std::vector<std::uint64_t> read_words(const Location& at, const std::string& path) {
  return read_values<std::uint64_t>(at, path, H5T_NATIVE_UINT64);
}

InputArray read_array(const Location& at, const std::string& path) {
  const std::string what = doing(at, "read", path);
  const Handle dataset = open_dataset(at, path);
  const Handle type(H5Dget_type(dataset.id()), H5Tclose, what);
  InputArray array;
  for (const hsize_t size : dimensions_of(at, dataset.id())) array.shape.push_back(narrow<std::int64_t>(size));
  if (checked(H5Tequal(type.id(), H5T_IEEE_F32LE), what) > 0) {
    array.values = read_values<float>(at, path, H5T_NATIVE_FLOAT);
  } else if (checked(H5Tequal(type.id(), H5T_IEEE_F64LE), what) > 0) {
    array.values = read_values<double>(at, path, H5T_NATIVE_DOUBLE);
  } else {
    throw UserError(at.name, path + " is neither float32 nor float64");
  }
  return array;
}

std::string read_text(const Location& at, const std::string& path) {
  const std::string what = doing(at, "read", path);
  const Handle dataset = open_dataset(at, path);
  check_claim(at, path, dataset.id());
  const Handle type(H5Dget_type(dataset.id()), H5Tclose, what);
  if (H5Tget_class(type.id()) != H5T_STRING || !dimensions_of(at, dataset.id()).empty()) {
    throw UserError(at.name, path + " is not one text");
  }
  return text_value(type.id(), what, [&](void* bytes) {
    checked(H5Dread(dataset.id(), type.id(), H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes), what);
  });
}

std::map<std::string, Attribute> read_attributes(const Location& at, const std::string& path) {
  const std::string what = doing(at, "read attributes of", path);
  const Handle object = open_object(at, path);
  std::vector<std::string> names;
  checked(H5Aiterate2(object.id(), H5_INDEX_NAME, H5_ITER_INC, nullptr, collect_name, &names), what);
  std::map<std::string, Attribute> attributes;
  for (const std::string& name : names) {
    const Handle attribute(H5Aopen(object.id(), name.c_str(), H5P_DEFAULT), H5Aclose, what);
    if (const std::optional<Attribute> value = read_one(attribute.id(), what + "/@" + name)) attributes[name] = *value;
  }
  return attributes;
}

std::string read_text_attribute(const Location& at, const std::string& path, const std::string& key) {
  const std::string what = doing(at, "read attribute", path + "/@" + key);
  const Handle object = open_object(at, path);
  const Handle attribute(H5Aopen(object.id(), key.c_str(), H5P_DEFAULT), H5Aclose, what);
  const std::optional<Attribute> value = read_one(attribute.id(), what);
  if (!value || !std::holds_alternative<std::string>(*value)) throw UserError("", what + ": it is not one text");
  return std::get<std::string>(*value);
}

std::vector<std::int64_t> read_integers(const Location& at, const std::string& path, const std::string& key) {
  const std::string what = doing(at, "read attribute", path + "/@" + key);
  const Handle object = open_object(at, path);
  const Handle attribute(H5Aopen(object.id(), key.c_str(), H5P_DEFAULT), H5Aclose, what);
  const Handle type(H5Aget_type(attribute.id()), H5Tclose, what);
  if (H5Tget_class(type.id()) != H5T_INTEGER) throw UserError("", what + ": it holds no integers");
  std::vector<std::int64_t> values(num_elements(attribute.id(), what));
  checked(H5Aread(attribute.id(), H5T_NATIVE_INT64, values.data()), what);
  return values;
}

bool exists(const Location& at, const std::string& path) {
  return checked(H5Lexists(at.file, path.c_str(), H5P_DEFAULT), doing(at, "look up", path)) > 0;
}

std::vector<std::string> links_in_order(const Location& at, const std::string& path) {
  const std::string what = doing(at, "list", path);
  const Handle group(H5Gopen2(at.file, path.c_str(), H5P_DEFAULT), H5Gclose, what);
  // In the order of their making where the group keeps it; another program may have rewritten it without.
  const Handle list(H5Gget_create_plist(group.id()), H5Pclose, what);
  unsigned flags = 0;
  checked(H5Pget_link_creation_order(list.id(), &flags), what);
  const H5_index_t order = (flags & H5P_CRT_ORDER_TRACKED) != 0 ? H5_INDEX_CRT_ORDER : H5_INDEX_NAME;
  H5G_info_t info{};
  checked(H5Gget_info(group.id(), &info), what);
  std::vector<std::string> names;
  for (hsize_t i = 0; i < info.nlinks; ++i) {
    const auto name_at = [&](char* name, std::size_t size) {
      const ssize_t length = H5Lget_name_by_idx(group.id(), ".", order, H5_ITER_INC, i, name, size, H5P_DEFAULT);
      return static_cast<std::size_t>(checked(length, what));
    };
    std::string name(name_at(nullptr, 0), '\0');
    name_at(name.data(), name.size() + 1);
    names.push_back(name);
  }
  return names;
}

}  // namespace noiseloom::hdf5
