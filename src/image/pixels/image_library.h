// What the reader and the writer of image files ask of the image library, which is OpenImageIO.
//
// The library is a module, loaded when the first image is opened: OpenImageIO brings some 270 shared libraries, a
// quarter of a second at every start, and most commands open no image. So this header knows nothing of it, and only
// library/openimageio.cpp, which is the module, includes its headers.
//
// Module and program share no code but what is written here. Nothing that is asked throws: what went wrong is said in
// the library's own words, by error().
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "noiseloom/image/image_io.h"
#include "noiseloom/image/volume.h"

namespace noiseloom {

// What the file says of one of its parts.
struct ImagePart {
  ImageShape shape;
  std::string other_type;  // the name of its type of numbers where it is none of PixelType, else empty
  bool flat = true;        // not a volume
  bool deep = false;       // several values a pixel
  int tile_width = 0;      // 0: stored in rows
  int tile_height = 0;
  // Where data window and display window begin, and the size of the latter.
  int x = 0;
  int y = 0;
  int full_x = 0;
  int full_y = 0;
  int full_width = 0;
  int full_height = 0;
  bool is_srgb = false;  // marked as colours that a sampler decodes
  // What a file that was exported here says of itself: pairs of key and text.
  std::vector<std::pair<std::string, std::string>> facts = {};
};

class ImageInput {
 public:
  virtual ~ImageInput() = default;
  virtual bool open(const std::string& path) = 0;
  // Goes to a part, counted from 0; false where there is none.
  virtual bool seek(int part) = 0;
  virtual ImagePart part() const = 0;  // the one it has gone to
  // All pixels of that part, or the rows [first, end) counted from the top of its data window.
  virtual bool read_all(PixelType type, std::byte* bytes) = 0;
  virtual bool read_rows(int first, int end, PixelType type, std::byte* bytes) = 0;
  virtual std::string error() = 0;
};

class ImageOutput {
 public:
  virtual ~ImageOutput() = default;
  virtual bool open(const std::string& path, const ImageJob& job) = 0;
  virtual bool write_block(int block, const std::byte* bytes) = 0;  // from the first to the last
  virtual bool close() = 0;
  virtual std::string error() = 0;
};

class ImageLibrary {
 public:
  virtual ~ImageLibrary() = default;
  // The most that a file which is read may claim to hold.
  virtual void limit_image_size(int megabytes) const = 0;
  // For a format as the library names it; null where it has none, and error() then says so.
  virtual std::unique_ptr<ImageInput> input(const std::string& format) const = 0;
  virtual std::unique_ptr<ImageOutput> output(ImageFormat format) const = 0;
  virtual std::string error() const = 0;
  // A grid of OpenVDB: empty, or what is wrong, of which a fault is made. Values are not looked at.
  virtual std::string read_volume(const std::string& path, const std::string& grid, VolumeBox& volume) const = 0;
};

// Loads the library at the first call. Throws EnvironmentError where it cannot be loaded.
const ImageLibrary& image_library();

// The library's own words, or that there are none.
inline std::string words_of(const std::string& library_error) {
  return library_error.empty() ? "the image library gave no reason" : library_error;
}

// The function of the module that gives its library. Its name counts the changes of this header, so that a module of
// another version is not taken.
inline constexpr const char* image_library_function = "noiseloom_image_library_5";
using ImageLibraryFunction = const ImageLibrary* (*)();

}  // namespace noiseloom
