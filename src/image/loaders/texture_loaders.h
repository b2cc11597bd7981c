// The loaders behind load_texture, one for each kind of file. Each gives the numbers as they are stored; interpret()
// makes samples of them.
#pragma once

#include "image/facts/provenance.h"
#include "noiseloom/core/number_type.h"
#include "noiseloom/image/encoding.h"
#include "noiseloom/image/texture_file.h"

namespace noiseloom::loaders {

struct Request {
  std::string path;
  std::optional<RunConfig> config;
  TextureReading reading;
  // Where an image no longer has the size that it says of itself, it is taken as it is, and nothing it says is
  // believed.
  bool any_size = false;
};

// The numbers of a file with all its channels.
struct Stored {
  enum class Coding {
    codes,   // 0..1, which stand for the range of the samples
    values,  // the values themselves
    open     // floats: values, or 0..1 where none of a signed space is negative
  };
  Texture texture;
  std::vector<std::string> channel_names;  // of every channel
  Coding coding = Coding::open;
  std::optional<ValueRange> range;  // of codes, where the file says it
  double step = 0;                  // between neighbouring numbers; 0: floats
  std::optional<RunConfig> config;  // that the file brings
  bool is_srgb = false;             // marked as colours that samplers decode
  std::string source;
  std::vector<std::string> notes;
};

TextureFile run_file(const Request& request);
Stored images(const Request& request);
Stored npy(const Request& request);
Stored raw(const Request& request);
Stored hdf5_dataset(const Request& request);

// Of the first image. Throws as own_facts() does, and as ImageReader.
std::optional<OwnFacts> own_facts_of_images(const std::string& path, const std::vector<std::string>& overrides = {});
// What TextureReading says for a layout that a file names; "" where it is found.
std::string reading_of_layout(const std::string& layout);

Extents suggested_image_extents(const std::string& path, const TextureReading& reading,
                                std::vector<std::string>& notes);

// An array as its file holds it, last dimension fastest.
struct StoredArray {
  std::vector<std::int64_t> shape;
  std::vector<double> values;
  NumberType type;
};
// Which dimension is which, found from the request's config and reading.
Stored array_texture(const Request& request, const StoredArray& array);
// The same for an array whose config leaves the size open. `channels`: 0 where that is open too.
Extents suggested_array_extents(const std::string& path, const std::vector<std::int64_t>& shape, int channels,
                                const TextureReading& reading);

// The samples: chooses the channels, decodes, and says in notes what had to be assumed.
TextureFile interpret(Stored stored, const Request& request);

// Channels that samples of the config have; 0 where only the file knows.
int config_channels(const RunConfig& config);
int config_channels(const std::optional<RunConfig>& config);
// Where samples of `wanted` channels (0: any number) may be taken from pixels of `found`.
bool channels_fit(int found, int wanted);
// What stored numbers 0..1 stand for.
ValueRange stored_range(const std::optional<RunConfig>& config);
// "3 slices of 128 x 128", for messages.
std::string expected_size(const Extents& extents);

// "[64, 128, 128]"
std::string shape_text(const std::vector<std::int64_t>& shape);

}  // namespace noiseloom::loaders
