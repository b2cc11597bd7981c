// Void-and-cluster masks, and run files that hold them.
#pragma once

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "noiseloom/construct/void_and_cluster.h"
#include "noiseloom/dist/communicator.h"
#include "noiseloom/files/order_codec.h"
#include "support/mpi_session.h"
#include "support/run_files.h"
#include "support/sanitizers.h"
#include "support/vac_specs.h"

namespace noiseloom {

// The place of every pixel, x fastest.
inline std::vector<std::uint64_t> mask_places(const VacSpec& spec) {
  const Communicator communicator = Communicator::self();
  ThreadPool pool(1);
  VoidAndCluster run(spec, communicator, pool);
  run.start();
  run.advance(std::numeric_limits<std::int64_t>::max());
  std::vector<std::uint64_t> places;
  for (const SliceIndex s : spec.extents.slices()) {
    const std::vector<std::byte> bytes = run.order(s);
    for (std::size_t cell = 0; cell < run.codec().num_pixels(bytes); ++cell)
      places.push_back(run.codec().get(bytes, cell));
  }
  return places;
}

// (place + 0.5) / N, as float.
inline Texture mask_texture(const Extents& extents, const std::vector<std::uint64_t>& places) {
  Texture texture = make_texture(extents, 1);
  for (std::size_t i = 0; i < places.size(); ++i)
    texture.values[i] =
        static_cast<float>((static_cast<double>(places[i]) + 0.5) / static_cast<double>(extents.num_cells()));
  return texture;
}

inline RunConfig mask_config(const Extents& extents) {
  std::string size;
  for (int axis = 0; axis < extents.num_axes(); ++axis)
    size += (axis == 0 ? "" : ", ") + extents.name(axis) + " = " + std::to_string(extents.size(axis));
  std::string groups = "{ axes = \"xy\", kernel = \"gauss-energy\", sigma = 1.9 }";
  if (extents.num_axes() > 2) {
    std::string axes;
    for (int axis = 2; axis < extents.num_axes(); ++axis) axes += extents.name(axis);
    groups += ", { axes = \"" + axes + "\", kernel = \"gauss-energy\", sigma = 1.9 }";
  }
  return parse_config("[texture]\nsize = { " + size +
                          " }\nsamples = \"uniform\"\n[filter]\ncombine = \"sum\"\ngroups = [ " + groups + " ]\n",
                      "mask.toml", "", {});
}

// A run file with /order, and /samples that follow from it.
inline void write_mask_file(const std::string& path, const Extents& extents, const std::vector<std::uint64_t>& places,
                            ElementType type = ElementType::uint32) {
  RunFileContent content;
  content.extents = extents;
  content.config = to_toml(mask_config(extents));
  content.datasets = {{"/samples", ElementType::float32, 1, true}, {order_name, type, 1, false}};
  const Texture texture = mask_texture(extents, places);
  const std::size_t cells = static_cast<std::size_t>(extents.cells_per_slice());
  const OrderCodec codec(type);
  std::vector<std::byte> bytes(cells * codec.bytes_per_pixel());
  RunFileWriter writer(posix_file_ops(), path, content);
  for (const SliceIndex s : extents.slices()) {
    writer.write_slice(0, s, std::as_bytes(std::span(texture.slice(s), cells)));
    const std::span<const std::uint64_t> slice(places.data() + static_cast<std::size_t>(s) * cells, cells);
    codec.write(slice, bytes);
    writer.write_slice(1, s, bytes);
  }
  writer.publish();
}

}  // namespace noiseloom
