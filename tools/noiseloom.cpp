// noiseloom: generate, plan and info; everything else is run in noiseloom-study, which links the image libraries.

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <climits>
#include <cstring>
#include <filesystem>
#include <string>

#include "noiseloom/core/error.h"
#include "noiseloom_commands.h"

namespace noiseloom {
namespace {

constexpr const char* usage =
    R"(noiseloom weaves sampling-noise textures: arrays that give every pixel of every frame a random
value whose error your denoiser removes best.

  noiseloom generate CONFIG.toml -o RUN.h5     make a texture (alone or under mpirun/srun)
  noiseloom plan CONFIG.toml [--ranks N]       memory, messages and time, before a long run
  noiseloom info RUN.h5                        what a run file holds and how far it got

  noiseloom export RUN.h5 -o DIR               run file to images (PNG, EXR, TIFF, HDR, npy, raw)
  noiseloom score FILE [--config C.toml]       relative error of a run file or of anybody's images
  noiseloom analyze FILE -o DIR                spectra and convergence as report.html
  noiseloom accuracy CONFIG.toml -o DIR        what accuracy costs: error against seconds, as report.html

  noiseloom COMMAND --help                     the options of a command
  noiseloom --help-config                      every setting of a config
  noiseloom --version

A first texture:
  noiseloom generate configs/quick.toml -o quick.h5 && noiseloom export quick.h5 -o quick

Exit status: 0 done; 1 the environment failed (disk, MPI); 2 the input is wrong (nothing was started); 75 stopped early
with everything saved: run the same command again with --resume.
)";

const std::vector<std::string>& study_commands() {
  static const std::vector<std::string> commands = {"export", "score", "analyze", "accuracy"};
  return commands;
}

// The image libraries that noiseloom-study is linked with take about 400 MB of address space before its main begins,
// and abort without a word of what is missing.
bool has_room_for_study() {
  constexpr rlim_t least = 500'000'000;
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY || limit.rlim_cur >= least) return true;
  fmt::print(stderr,
             "out of memory: this shell allows a process {} MB of address space (ulimit -v), and the image libraries "
             "alone take about 400; accepted: {} MB and more\n",
             limit.rlim_cur / 1'000'000, least / 1'000'000);
  return false;
}

// Replaces this process by noiseloom-study, installed beside this program.
int run_study(char** argv) {
  if (!has_room_for_study()) return 1;
  std::array<char, PATH_MAX> self{};
  const ssize_t length = readlink("/proc/self/exe", self.data(), self.size() - 1);
  if (length > 0) {
    const std::filesystem::path beside = std::filesystem::path(self.data()).parent_path() / "noiseloom-study";
    execv(beside.c_str(), argv);
  }
  execvp("noiseloom-study", argv);
  fmt::print(stderr, "noiseloom-study: {}; it belongs beside noiseloom\n", std::strerror(errno));
  return exit_environment;
}

int unknown_command(const std::string& word) {
  std::vector<std::string> known = study_commands();
  known.insert(known.end(), {"generate", "plan", "info"});
  const std::string near = nearest_word(word, known);
  fmt::print(stderr, "noiseloom: \"{}\": unknown command{}; see noiseloom --help\n", word,
             near.empty() ? "" : fmt::format("; did you mean \"{}\"?", near));
  return exit_user;
}

}  // namespace

void print_faults(const std::string& faults) {
  const auto count = 1 + std::count(faults.begin(), faults.end(), '\n');
  fmt::print(stderr, "{}\n{} {}; nothing was started\n", faults, count, count == 1 ? "error" : "errors");
}

}  // namespace noiseloom

int main(int argc, char** argv) {
  using namespace noiseloom;
  const std::string command = argc > 1 ? argv[1] : "";
  try {
    if (command.empty() || command == "--help" || command == "-h" || command == "help") {
      fmt::print("{}", usage);
      return command.empty() ? exit_user : exit_done;
    }
    if (command == "--version") {
      fmt::print("noiseloom {}\n", NOISELOOM_VERSION);
      return exit_done;
    }
    if (command == "--help-config") return run_plan(argc, argv);
    if (command == "generate") return run_generate(argc, argv);
    if (command == "plan") return run_plan(argc, argv);
    if (command == "info") return run_info(argc, argv);
    const auto& study = study_commands();
    if (std::find(study.begin(), study.end(), command) != study.end()) return run_study(argv);
    return unknown_command(command);
  } catch (const UserError& error) {
    print_faults(error.what());
    return exit_user;
  } catch (const std::exception& error) {
    fmt::print(stderr, "noiseloom {}: {}\n", command, error.what());
    return exit_environment;
  }
}
