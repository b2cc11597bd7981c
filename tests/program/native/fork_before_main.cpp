// Preloaded into a program under test: it is loaded once, libraries and all, and stops before its main; each command
// line that it is then sent runs in a fork of it. To load the libraries that read images takes ten times as long as
// most of what tests do with them, and they start the programs thousands of times. What runs is the program itself,
// from the first line of main to the handlers of exit that it registered; what is done before main and after those
// handlers (global objects, libraries that are loaded and unloaded) is not, and the addresses of one process are those
// of the next. What a process opens as it runs (dlopen) is opened here too, before those that follow are forked; should
// a library then start threads, a fork has none of them and may wait for one until the test's time is out.
//
// FORK_SOCKET = n: a socket (SOCK_SEQPACKET) on which commands come, one a message: variables of the environment
// (NAME=VALUE), an empty word, the working directory and the words of the command line, each with a 0 behind it, and
// two file descriptors for standard output and error. The answers are the process's number and, when it has ended, what
// waitpid says of it.

#include <dlfcn.h>
#include <link.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <set>
#include <string>
#include <vector>

namespace {

using Main = int (*)(int, char**, char**);
using StartMain = int (*)(Main, int, char**, void (*)(), void (*)(), void (*)(), void*);

Main program_main;

[[noreturn]] void fail(const char* what) {
  std::perror(what);
  _exit(127);
}

// The files of libraries that a fork opened, each with a 0 behind it and another at the end: in memory that forks share
// with the process that forks.
constexpr std::size_t opened_capacity = std::size_t{1} << 17;
char* opened;
std::set<std::string> loaded;

std::set<std::string> libraries() {
  std::set<std::string> paths;
  const auto add = [](dl_phdr_info* library, std::size_t, void* to) {
    if (library->dlpi_name != nullptr && library->dlpi_name[0] == '/')
      static_cast<std::set<std::string>*>(to)->insert(library->dlpi_name);
    return 0;
  };
  dl_iterate_phdr(add, &paths);
  return paths;
}

// At the end of a process that was forked. Some libraries start threads as they are loaded and wait for them when they
// are unloaded; a fork has none of these threads.
void end_without_libraries(int status, void*) {
  std::string paths;
  for (const std::string& path : libraries())
    if (!loaded.contains(path)) paths += path + '\0';
  if (paths.size() < opened_capacity) std::memcpy(opened, paths.c_str(), paths.size() + 1);
  std::fflush(nullptr);
  _exit(status);
}

void open_what_was_opened() {
  if (*opened == 0) return;
  for (const char* path = opened; *path != 0; path += std::strlen(path) + 1) dlopen(path, RTLD_LAZY);
  loaded = libraries();
  *opened = 0;
}

struct Command {
  std::vector<char> text;
  int out = -1;
  int error = -1;
};

// Whether there is another; there is none when the other end was closed.
bool receive(int socket, Command& command) {
  command.text.resize(std::size_t{1} << 17);
  alignas(cmsghdr) char control[CMSG_SPACE(2 * sizeof(int))] = {};
  iovec part = {command.text.data(), command.text.size()};
  msghdr message = {};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control;
  message.msg_controllen = sizeof(control);
  const ssize_t size = recvmsg(socket, &message, MSG_CMSG_CLOEXEC);
  if (size < 0) fail("recvmsg");
  if (size == 0) return false;
  const cmsghdr* descriptors = CMSG_FIRSTHDR(&message);
  if ((message.msg_flags & MSG_TRUNC) != 0 || descriptors == nullptr) fail("command");
  int both[2];
  std::memcpy(both, CMSG_DATA(descriptors), sizeof(both));
  command.out = both[0];
  command.error = both[1];
  command.text.resize(static_cast<std::size_t>(size));
  return true;
}

[[noreturn]] void run(Command& command) {
  if (dup2(command.out, STDOUT_FILENO) < 0 || dup2(command.error, STDERR_FILENO) < 0) fail("dup2");
  char* word = command.text.data();
  for (; *word != 0; word += std::strlen(word) + 1) putenv(word);
  std::vector<char*> words;
  for (++word; word < command.text.data() + command.text.size(); word += std::strlen(word) + 1) words.push_back(word);
  if (chdir(words.front()) != 0) fail(words.front());
  const int count = static_cast<int>(words.size()) - 1;
  words.push_back(nullptr);
  on_exit(end_without_libraries, nullptr);
  std::exit(program_main(count, words.data() + 1, environ));  // the words are needed until the last handler has run
}

void answer(int socket, int value) {
  if (send(socket, &value, sizeof(value), MSG_NOSIGNAL) < 0) _exit(0);  // nobody listens any more
}

int serve(int, char**, char**) {
  const int socket = std::atoi(std::getenv("FORK_SOCKET"));
  for (const char* name : {"FORK_SOCKET", "LD_PRELOAD"}) unsetenv(name);
  void* shared = mmap(nullptr, opened_capacity, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (shared == MAP_FAILED) fail("mmap");
  opened = static_cast<char*>(shared);
  loaded = libraries();
  for (Command command; receive(socket, command);) {
    const pid_t child = fork();
    if (child < 0) fail("fork");
    if (child == 0) {
      close(socket);
      run(command);
    }
    close(command.out);
    close(command.error);
    answer(socket, child);
    int status = 0;
    if (waitpid(child, &status, 0) < 0) fail("waitpid");
    answer(socket, status);
    open_what_was_opened();
  }
  _exit(0);
}

}  // namespace

// Nothing is closed any more, so that what a fork opened is known at its end.
extern "C" int dlclose(void* library) noexcept {
  if (opened != nullptr) return 0;
  const auto close_it = reinterpret_cast<int (*)(void*)>(dlsym(RTLD_NEXT, "dlclose"));
  return close_it(library);
}

// The C library's start of a program, which would call main.
extern "C" int __libc_start_main(Main main, int argc, char** argv, void (*init)(), void (*fini)(),
                                 void (*loader_fini)(), void* stack_end) {
  program_main = main;
  const auto start = reinterpret_cast<StartMain>(dlsym(RTLD_NEXT, "__libc_start_main"));
  return start(std::getenv("FORK_SOCKET") != nullptr ? serve : main, argc, argv, init, fini, loader_fini, stack_end);
}
