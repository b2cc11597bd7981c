#include "noiseloom_images.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <climits>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <map>
#include <utility>
#include <vector>

#include "noiseloom/config/config.h"
#include "noiseloom/core/error.h"
#include "noiseloom/files/image_decoder.h"
#include "noiseloom/samples/luminance.h"
#include "noiseloom_commands.h"
#include "noiseloom_pixels.h"

extern char** environ;

namespace noiseloom {
namespace {

class Pipe {
 public:
  Pipe() {
    if (::pipe2(ends_.data(), O_CLOEXEC) != 0) {
      throw EnvironmentError(fmt::format("a pipe to noiseloom-study: {}", std::strerror(errno)));
    }
  }
  ~Pipe() {
    close_writing();
    ::close(ends_[0]);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;

  int writing_end() const { return ends_[1]; }
  void close_writing() {
    if (ends_[1] >= 0) ::close(ends_[1]);
    ends_[1] = -1;
  }
  // Up to `size` bytes; less at the end only.
  std::size_t read(char* bytes, std::size_t size) const {
    std::size_t done = 0;
    while (done < size) {
      const ssize_t count = ::read(ends_[0], bytes + done, size - done);
      if (count == 0) break;
      if (count < 0 && errno != EINTR) {
        throw EnvironmentError(fmt::format("noiseloom-study: its answer cannot be read: {}", std::strerror(errno)));
      }
      if (count > 0) done += static_cast<std::size_t>(count);
    }
    return done;
  }

 private:
  std::array<int, 2> ends_{-1, -1};
};

class Child {
 public:
  Child(std::vector<std::string> words, int standard_output) {
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, standard_output, STDOUT_FILENO);
    const std::string beside = study_beside();
    const int error = beside.empty()
                          ? ::posix_spawnp(&process_, "noiseloom-study", &actions, nullptr, arguments.data(), environ)
                          : ::posix_spawn(&process_, beside.c_str(), &actions, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (error == 0) return;
    throw EnvironmentError(
        fmt::format("noiseloom-study, which reads images for noiseloom, cannot be run: {}; it belongs "
                    "beside noiseloom (a .npy is read without it)",
                    std::strerror(error)));
  }
  ~Child() { wait(); }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  // The status that it ends with, as waitpid says it.
  int wait() {
    while (process_ > 0 && ::waitpid(process_, &status_, 0) < 0 && errno == EINTR) {
    }
    process_ = 0;
    return status_;
  }

 private:
  pid_t process_ = 0;
  int status_ = 0;
};

InputArrayPtr ask_study(const std::string& path) {
  Pipe answer;
  Child child({"noiseloom-study", "pixels", "--", path}, answer.writing_end());
  answer.close_writing();
  PixelsHeader header{};
  if (answer.read(reinterpret_cast<char*>(&header), sizeof header) != sizeof header || header.magic != pixels_magic) {
    throw EnvironmentError(fmt::format("{}: noiseloom-study gave no answer (status {})", path, child.wait()));
  }
  if (header.what != PixelsHeader::What::pixels) {
    std::string words(header.sizes[0], '\0');
    words.resize(answer.read(words.data(), words.size()));
    if (header.what == PixelsHeader::What::user_error) throw UserError(path, words);
    throw EnvironmentError(words);
  }
  const auto& [height, width, channels] = header.sizes;
  std::vector<float> values(height * width * channels);
  const std::size_t bytes = values.size() * sizeof(float);
  if (answer.read(reinterpret_cast<char*>(values.data()), bytes) != bytes) {
    throw EnvironmentError(fmt::format("{}: noiseloom-study was cut off (status {})", path, child.wait()));
  }
  return std::make_shared<const InputArray>(InputArray{
      {static_cast<std::int64_t>(height), static_cast<std::int64_t>(width), static_cast<std::int64_t>(channels)},
      std::move(values)});
}

std::map<std::string, InputArrayPtr>& decoded_early() {
  static std::map<std::string, InputArrayPtr> images;
  return images;
}

// The number that a launcher gave this process; 0 where it gave none. Open MPI's own comes first: a job script has one
// from Slurm, too, which its mpirun hands on to all ranks.
bool may_be_first_rank() {
  for (const char* name : {"OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK", "SLURM_PROCID"}) {
    const char* const text = std::getenv(name);
    if (text != nullptr) return std::strcmp(text, "0") == 0;
  }
  return true;
}

}  // namespace

std::string study_beside() {
  std::array<char, PATH_MAX> self{};
  const ssize_t length = ::readlink("/proc/self/exe", self.data(), self.size() - 1);
  if (length <= 0) return "";
  const std::filesystem::path beside = std::filesystem::path(self.data()).parent_path() / "noiseloom-study";
  return ::access(beside.c_str(), X_OK) == 0 ? beside.string() : "";
}

void let_study_decode_images() {
  set_image_decoder([](const std::string& path) {
    // Whoever asks keeps what is needed of it, and that is a third of it.
    InputArrayPtr at_hand = std::exchange(decoded_early()[path], nullptr);
    return at_hand ? at_hand : ask_study(path);
  });
}

void decode_images_early(const std::string& config, const std::vector<std::string>& overrides) {
  if (!may_be_first_rank()) return;
  try {
    const SampleSpec samples = load_config(config, overrides).problem.samples;
    if (samples.is_image() && is_decoded(samples.file)) decoded_early()[samples.file] = ask_study(samples.file);
  } catch (const std::exception&) {
  }
}

}  // namespace noiseloom
