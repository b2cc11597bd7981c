#include <fmt/format.h>

#include <filesystem>

#include "noiseloom/files/generations.h"
#include "noiseloom/files/output_files.h"
#include "noiseloom/image/encoding.h"
#include "noiseloom/image/sequence.h"
#include "published/programs.h"

namespace noiseloom {
namespace {

std::string file_of_step(const std::string& file, std::int64_t step) {
  if (step == 0) return file;
  const std::filesystem::path path(file);
  return (path.parent_path() / fmt::format("{}.{}{}", path.stem().string(), step, path.extension().string())).string();
}

// The rows of a slice: its numbers in quotes.
std::string csv_rows(const std::vector<float>& values, std::size_t width, std::size_t channels) {
  const PixelLayout pixel = pixel_of_size(4, static_cast<int>(channels));
  std::string text;
  for (std::size_t cell = 0; cell * channels < values.size(); ++cell)
    for (std::size_t c = 0; c < pixel.source.size(); ++c) {
      const int source = pixel.source[c];
      const float value = source >= 0                ? values[cell * channels + static_cast<std::size_t>(source)]
                          : source == opaque_channel ? 1.0F
                                                     : 0.0F;
      const bool ends_row = (cell + 1) % width == 0 && c + 1 == pixel.source.size();
      text += fmt::format("\"{:f}\"{}", value, ends_row ? "\n" : ",");
    }
  return text;
}

}  // namespace

const std::vector<PublishedProgram>& published_programs() {
  static const std::vector<PublishedProgram> programs = {
      {"fastnoise", "lines of the published program of filter-adapted noise", fastnoise_help(), read_fastnoise},
      {"stbn-scalar", "lines of the published maker of scalar blue noise", stbn_scalar_help(), read_stbn_scalar},
      {"stbn-vector", "lines of the published maker of vector blue noise", stbn_vector_help(), read_stbn_vector},
  };
  return programs;
}

const PublishedProgram* find_published_program(const std::string& name) {
  for (const PublishedProgram& program : published_programs())
    if (program.name == name) return &program;
  return nullptr;
}

std::vector<std::string> published_files(const PublishedLine& line, std::int64_t step) {
  const std::string file = file_of_step(line.images.output, step);
  if (line.images.layout != "slices") return {file};
  std::vector<std::string> files;
  for (std::int64_t slice = 0; slice < line.slices; ++slice) files.push_back(fill_pattern(file, slice));
  return files;
}

ExportOptions images_of_step(const PublishedLine& line, std::int64_t step) {
  ExportOptions images = line.images;
  images.output = file_of_step(images.output, step);
  return images;
}

void write_csv(const std::string& run_file, const std::vector<std::string>& files, bool overwrite, FileOps& ops) {
  const RunFileReader reader = open_to_look_at(run_file);
  const int samples = reader.dataset("/samples");
  if (samples < 0) throw UserError(run_file, "holds no /samples");
  const Extents& extents = reader.content().extents;
  const auto channels = static_cast<std::size_t>(reader.content().datasets[static_cast<std::size_t>(samples)].channels);
  std::vector<float> values(static_cast<std::size_t>(extents.cells_per_slice()) * channels);
  OutputFiles output(ops, overwrite);
  output.check(files);
  const bool one_a_slice = files.size() > 1;
  std::unique_ptr<OutputStream> stream;
  for (const SliceIndex slice : extents.slices()) {
    if (one_a_slice || stream == nullptr) {
      if (stream != nullptr) stream->close();
      stream = output.open(files[one_a_slice ? static_cast<std::size_t>(slice) : 0]);
    }
    reader.read_slice(samples, slice, std::as_writable_bytes(std::span(values)));
    stream->append(csv_rows(values, static_cast<std::size_t>(extents.width()), channels));
  }
  stream->close();
  output.commit();
}

}  // namespace noiseloom
