// Arrays (.npy, HDF5): which dimension is which. Written here and by most: [slice axes..., y, x] or [slice axes..., y,
// x, channel], slice axes possibly flattened into one; others put the slices last: [y, x, slice].
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "image/loaders/texture_loaders.h"
#include "noiseloom/files/hdf5_array.h"
#include "noiseloom/files/npy.h"

namespace noiseloom::loaders {
namespace {

constexpr std::int64_t most_channels = 8;  // that are taken for channels where nothing else says so

// The dimensions by what they are; slices slowest first, with the names that were given ("" where none were).
struct Roles {
  std::size_t x = 0;
  std::size_t y = 0;
  std::optional<std::size_t> channel;
  std::vector<std::size_t> slices;
  std::vector<std::string> slice_names;
  std::string letters;  // "tyx"
};

using Shape = std::vector<std::int64_t>;

std::int64_t num_slices(const Roles& roles, const Shape& shape) {
  return std::accumulate(roles.slices.begin(), roles.slices.end(), std::int64_t{1},
                         [&](std::int64_t n, std::size_t d) { return n * shape[d]; });
}

std::int64_t num_channels(const Roles& roles, const Shape& shape) { return roles.channel ? shape[*roles.channel] : 1; }

std::string size_text(const Roles& roles, const Shape& shape) {
  const std::int64_t slices = num_slices(roles, shape);
  const std::int64_t channels = num_channels(roles, shape);
  return fmt::format("{} slice{} of {} x {}{}", slices, slices == 1 ? "" : "s", shape[roles.x], shape[roles.y],
                     roles.channel ? fmt::format(" with {} channel{}", channels, channels == 1 ? "" : "s") : "");
}

// Slices first ("tyx") or last ("yxt"), then the channel, if there is one.
Roles usual_roles(std::size_t dimensions, bool slices_last, bool has_channel) {
  Roles roles;
  const std::size_t axes = dimensions - (has_channel ? 1 : 0);
  if (has_channel) roles.channel = dimensions - 1;
  const std::size_t first_slice = slices_last ? 2 : 0;
  roles.y = slices_last ? 0 : axes - 2;
  roles.x = roles.y + 1;
  roles.letters.assign(dimensions, 't');
  for (std::size_t d = 0; d + 2 < axes; ++d) {
    roles.slices.push_back(first_slice + d);
    roles.slice_names.emplace_back();
    constexpr std::string_view names = "tzwvus";  // slowest first: the last of them is t
    roles.letters[first_slice + d] = names[std::min(axes - 3 - d, names.size() - 1)];
  }
  roles.letters[roles.y] = 'y';
  roles.letters[roles.x] = 'x';
  if (has_channel) roles.letters.back() = 'c';
  return roles;
}

// "tyx" or "time,y,x,channel"
Roles given_roles(const std::string& text, std::size_t dimensions) {
  std::vector<std::string> names;
  if (text.find(',') == std::string::npos && text.size() == dimensions) {
    for (const char letter : text) names.emplace_back(1, letter);
  } else {
    for (std::size_t at = 0; at <= text.size();) {
      const std::size_t end = std::min(text.find(',', at), text.size());
      names.push_back(text.substr(at, end - at));
      at = end + 1;
    }
  }
  Roles roles;
  bool has_x = false;
  bool has_y = false;
  bool sound = names.size() == dimensions;
  for (std::size_t d = 0; d < names.size() && sound; ++d) {
    const std::string& name = names[d];
    sound = !name.empty() && std::count(names.begin(), names.end(), name) == 1;
    if (name == "x") {
      roles.x = d;
      has_x = true;
    } else if (name == "y") {
      roles.y = d;
      has_y = true;
    } else if (name == "c" || name == "channel") {
      sound = sound && !roles.channel;
      roles.channel = d;
    } else {
      roles.slices.push_back(d);
      roles.slice_names.push_back(name);
    }
  }
  if (!sound || !has_x || !has_y)
    throw UserError("command line",
                    fmt::format("--axes {}: must name the {} dimensions of the array, slowest first, x and "
                                "y among them, such as tyx, yxt, yxc or time,y,x,channel",
                                text, dimensions));
  roles.letters = text;
  return roles;
}

// The slice dimensions in the order of the config's axes, slowest first, where they bear their names.
Roles in_order_of(Roles roles, const Extents& extents) {
  if (roles.slices.size() != static_cast<std::size_t>(extents.num_slice_axes())) return roles;
  Roles ordered = roles;
  for (int axis = 2; axis < extents.num_axes(); ++axis) {
    const auto found = std::find(roles.slice_names.begin(), roles.slice_names.end(), extents.name(axis));
    if (found == roles.slice_names.end()) return roles;
    const std::size_t place = static_cast<std::size_t>(extents.num_axes() - 1 - axis);
    ordered.slices[place] = roles.slices[static_cast<std::size_t>(found - roles.slice_names.begin())];
  }
  return ordered;
}

bool has_size(const Roles& roles, const Shape& shape, const Extents& extents) {
  return shape[roles.x] == extents.width() && shape[roles.y] == extents.height() &&
         num_slices(roles, shape) == extents.num_slices();
}

bool has_channels(const Roles& roles, const Shape& shape, int wanted) {
  const std::int64_t found = num_channels(roles, shape);
  return found >= 1 && found <= 1024 && channels_fit(static_cast<int>(found), wanted);
}

void check_shape(const std::string& path, const Shape& shape) {
  const bool empty = std::find(shape.begin(), shape.end(), 0) != shape.end();
  if (shape.size() < 2 || empty || shape.size() > static_cast<std::size_t>(Extents::max_axes) + 1)
    throw UserError(path, fmt::format("shape {}: must be [slice axes..., y, x] or [slice axes..., y, x, channel]",
                                      shape_text(shape)));
}

[[noreturn]] void ask(const std::string& path, const Shape& shape, const std::vector<Roles>& readings) {
  std::string list;
  for (const Roles& roles : readings)
    list += fmt::format("{}{} (--axes {})", list.empty() ? "" : ", ", size_text(roles, shape), roles.letters);
  throw UserError(path, fmt::format("shape {} fits {} readings: {}; say which by --axes", shape_text(shape),
                                    readings.size(), list));
}

// The readings that fit a config. What export writes (slices first, a dimension for the channel) is never doubtful.
Roles roles_for(const std::string& path, const Shape& shape, const Extents& extents, int wanted, bool channels_given) {
  const int least = channels_given ? 0 : wanted;
  std::vector<Roles> fitting;
  for (const bool has_channel : {true, false})
    for (const bool slices_last : {false, true}) {
      if (shape.size() < (has_channel ? 3U : 2U) || (slices_last && shape.size() != (has_channel ? 4U : 3U))) continue;
      const Roles roles = usual_roles(shape.size(), slices_last, has_channel);
      if (!has_size(roles, shape, extents) || !has_channels(roles, shape, least)) continue;
      if (has_channel && !slices_last) return roles;
      if (extents.num_slices() == 1 && slices_last && !fitting.empty()) continue;
      fitting.push_back(roles);
    }
  if (fitting.size() > 1) ask(path, shape, fitting);
  if (fitting.size() == 1) return fitting.front();
  Shape expected = extents.file_dimensions();
  if (wanted != 1) expected.push_back(wanted);
  throw UserError(path,
                  fmt::format("shape {}, but the config says {}{}; for dimensions in another order: --axes",
                              shape_text(shape), shape_text(expected), wanted == 0 ? " (the last of any size)" : ""));
}

// The readings of a shape that nothing else is known of: slices are more often square than not.
Roles suggested_roles(const std::string& path, const Shape& shape, int channels) {
  const bool small_last = shape.size() >= 3 && shape.back() <= most_channels;
  const bool has_channel =
      small_last && (channels == 0 || has_channels(usual_roles(shape.size(), false, true), shape, channels));
  const Roles first = usual_roles(shape.size(), false, has_channel);
  if (first.slices.size() != 1) return first;
  const Roles last = usual_roles(shape.size(), true, has_channel);
  const auto square = [&](const Roles& roles) { return shape[roles.x] == shape[roles.y]; };
  if (square(last) && !(square(first) && has_channel)) ask(path, shape, {first, last});
  return first;
}

// Integers as codes of 8 or 16 bits, or as places in an order (each of 0 to n - 1 equally often).
class IntegerCoding {
 public:
  IntegerCoding(const std::string& path, const StoredArray& array, bool scalar, const std::string& type) {
    const double least = *std::min_element(array.values.begin(), array.values.end());
    const double largest = *std::max_element(array.values.begin(), array.values.end());
    if (least < 0)
      throw UserError(path,
                      fmt::format("integers from {} to {}: negative ones are no codes; accepted: codes of 8 or 16 "
                                  "bits, places in an order, or floats",
                                  least, largest));
    if (!type.empty())
      levels_ = type_levels(type);
    else if (scalar && largest < 0x1p40 && is_order(array.values, largest))
      levels_ = largest + 1;
    else
      levels_ = array.type.bytes == 1 || largest < 256 ? 256 : 65536;
    if (largest >= levels_)
      throw UserError(path,
                      fmt::format("integers up to {}: neither codes of 8 or 16 bits nor places in an order, where "
                                  "each of 0 to n - 1 is there equally often",
                                  largest));
  }
  double levels() const { return levels_; }
  std::string note() const {
    if (levels_ == 256 || levels_ == 65536)
      return fmt::format("Integers were decoded as {} bit codes.", levels_ == 256 ? 8 : 16);
    return fmt::format("The integers are places in an order of {}: they were decoded as (place + 0.5) / {}.", levels_,
                       levels_);
  }

 private:
  static double type_levels(const std::string& type) {
    if (type == "uint8") return 256;
    if (type == "uint16") return 65536;
    throw UserError("command line", fmt::format("--type {}: accepted for integers in an array: uint8, uint16", type));
  }
  static bool is_order(const std::vector<double>& values, double largest) {
    const std::size_t levels = static_cast<std::size_t>(largest) + 1;
    if (levels < 2 || levels > values.size() || values.size() % levels != 0) return false;
    std::vector<std::uint32_t> counts(levels, 0);
    for (const double v : values) ++counts[static_cast<std::size_t>(v)];
    return std::all_of(counts.begin(), counts.end(), [&](std::uint32_t n) { return n == values.size() / levels; });
  }
  double levels_ = 256;
};

Extents extents_of(const Roles& roles, const Shape& shape) {
  std::vector<std::int64_t> sizes = {shape[roles.x], shape[roles.y]};
  for (std::size_t i = roles.slices.size(); i-- > 0;)
    if (shape[roles.slices[i]] > 1 || roles.slices.size() > 1) sizes.push_back(shape[roles.slices[i]]);
  if (sizes.size() > static_cast<std::size_t>(Extents::max_axes))
    sizes.resize(static_cast<std::size_t>(Extents::max_axes));
  return Extents(sizes);
}

}  // namespace

std::string shape_text(const std::vector<std::int64_t>& shape) {
  std::string text;
  for (const std::int64_t n : shape) text += fmt::format("{}{}", text.empty() ? "" : ", ", n);
  return "[" + text + "]";
}

Extents suggested_array_extents(const std::string& path, const std::vector<std::int64_t>& shape, int channels,
                                const TextureReading& reading) {
  check_shape(path, shape);
  return extents_of(reading.axes.empty() ? suggested_roles(path, shape, reading.channels.empty() ? channels : 0)
                                         : given_roles(reading.axes, shape.size()),
                    shape);
}

Stored array_texture(const Request& request, const StoredArray& array) {
  const std::string& path = request.path;
  const Shape& shape = array.shape;
  check_shape(path, shape);
  const int wanted = config_channels(request.config);
  const bool given = !request.reading.axes.empty();
  Roles roles = given ? given_roles(request.reading.axes, shape.size())
                : request.config
                    ? roles_for(path, shape, request.config->problem.extents, wanted, !request.reading.channels.empty())
                    : suggested_roles(path, shape, 0);
  const Extents extents = request.config ? request.config->problem.extents : extents_of(roles, shape);
  if (!has_size(roles, shape, extents))
    throw UserError(path, fmt::format("shape {} is {} by --axes {}, but the config says {}", shape_text(shape),
                                      size_text(roles, shape), request.reading.axes, expected_size(extents)));
  roles = in_order_of(std::move(roles), extents);
  Stored stored;
  stored.texture = make_texture(extents, narrow<int>(num_channels(roles, shape)));
  stored.source = "array";
  for (int c = 0; c < stored.texture.channels; ++c) stored.channel_names.push_back(std::to_string(c));
  stored.notes.push_back(fmt::format("The array of shape {} was taken as {} ({}).", shape_text(shape),
                                     size_text(roles, shape), roles.letters));
  double levels = 0;  // of integers
  if (array.type.is_integer()) {
    const IntegerCoding coding(path, array, wanted <= 1 && stored.texture.channels == 1, request.reading.type);
    levels = coding.levels();
    stored.coding = Stored::Coding::codes;
    stored.step = 1 / levels;
    stored.notes.push_back(coding.note());
  }
  std::vector<std::size_t> stride(shape.size(), 1);
  for (std::size_t d = shape.size() - 1; d-- > 0;) stride[d] = stride[d + 1] * static_cast<std::size_t>(shape[d + 1]);
  float* out = stored.texture.values.data();
  for (const SliceIndex s : extents.slices()) {
    std::size_t slice = 0;  // the offset of the slice's first number
    std::int64_t rest = s.value();
    for (std::size_t i = roles.slices.size(); i-- > 0;) {
      const std::int64_t size = shape[roles.slices[i]];
      slice += static_cast<std::size_t>(rest % size) * stride[roles.slices[i]];
      rest /= size;
    }
    for (int c = 0; c < stored.texture.channels; ++c)
      for (std::int64_t y = 0; y < extents.height(); ++y)
        for (std::int64_t x = 0; x < extents.width(); ++x) {
          const std::size_t at = slice + static_cast<std::size_t>(y) * stride[roles.y] +
                                 static_cast<std::size_t>(x) * stride[roles.x] +
                                 (roles.channel ? static_cast<std::size_t>(c) * stride[*roles.channel] : 0);
          *out++ = static_cast<float>(levels > 0 ? (array.values[at] + 0.5) / levels : array.values[at]);
        }
  }
  return stored;
}

Stored npy(const Request& request) {
  NpyArray array = read_npy(request.path);
  Stored stored = array_texture(request, {std::move(array.shape), std::move(array.values), array.type});
  stored.source = "NumPy array";
  return stored;
}

Stored hdf5_dataset(const Request& request) {
  Hdf5Array array = read_hdf5_array(request.path);
  Stored stored = array_texture(request, {std::move(array.shape), std::move(array.values), array.type});
  stored.source = "HDF5 dataset";
  return stored;
}

}  // namespace noiseloom::loaders
