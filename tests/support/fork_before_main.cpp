// Preloaded into a program under test: it is loaded once, libraries and all, and stops before its main; each command
// line that it is then sent runs in a fork of it. To load the libraries that read images takes ten times as long as
// most of what tests do with them, and they start the programs thousands of times. What runs is the program itself,
// from the first line of main to its exit; only the loader's work is not done anew.
//
// FORK_SOCKET = n: a socket (SOCK_SEQPACKET) on which commands come, one a message: variables of the environment
// (NAME=VALUE), an empty word, the working directory and the words of the command line, each with a 0 behind it, and
// two file descriptors for standard output and error. The answers are the process's number and, when it has ended, what
// waitpid says of it. FORK_MODULE = path: a module that the program opens when it needs it; once one process has done
// so, it is opened before those that follow are forked.

#include <dlfcn.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

namespace {

using Main = int (*)(int, char**, char**);
using StartMain = int (*)(Main, int, char**, void (*)(), void (*)(), void (*)(), void*);

Main program_main;
bool* module_is_needed;  // shared with the processes forked
std::string module_path;

[[noreturn]] void fail(const char* what) {
  std::perror(what);
  _exit(127);
}

bool is_open(const std::string& module) { return dlopen(module.c_str(), RTLD_NOW | RTLD_NOLOAD) != nullptr; }

void tell_of_module() {
  if (is_open(module_path)) *module_is_needed = true;
}

// Some of the image libraries start threads as they are loaded and wait for them at the end; a fork does not have them.
void end_without_libraries(int status, void*) {
  std::fflush(nullptr);
  _exit(status);
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

int run(Command& command) {
  if (dup2(command.out, STDOUT_FILENO) < 0 || dup2(command.error, STDERR_FILENO) < 0) fail("dup2");
  char* word = command.text.data();
  for (; *word != 0; word += std::strlen(word) + 1) putenv(word);
  std::vector<char*> words;
  for (++word; word < command.text.data() + command.text.size(); word += std::strlen(word) + 1) words.push_back(word);
  if (chdir(words.front()) != 0) fail(words.front());
  const int count = static_cast<int>(words.size()) - 1;
  words.push_back(nullptr);
  if (is_open(module_path)) {
    on_exit(end_without_libraries, nullptr);
  } else {
    std::atexit(tell_of_module);
  }
  return program_main(count, words.data() + 1, environ);
}

void answer(int socket, int value) {
  if (send(socket, &value, sizeof(value), MSG_NOSIGNAL) < 0) _exit(0);  // nobody listens any more
}

int serve(int, char**, char**) {
  const int socket = std::atoi(std::getenv("FORK_SOCKET"));
  const char* module = std::getenv("FORK_MODULE");
  module_path = module != nullptr ? module : "";
  for (const char* name : {"FORK_SOCKET", "FORK_MODULE", "LD_PRELOAD"}) unsetenv(name);
  void* shared = mmap(nullptr, sizeof(bool), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (shared == MAP_FAILED) fail("mmap");
  module_is_needed = static_cast<bool*>(shared);
  for (Command command; receive(socket, command);) {
    const pid_t child = fork();
    if (child < 0) fail("fork");
    if (child == 0) {
      close(socket);
      return run(command);
    }
    close(command.out);
    close(command.error);
    answer(socket, child);
    int status = 0;
    if (waitpid(child, &status, 0) < 0) fail("waitpid");
    answer(socket, status);
    if (std::exchange(*module_is_needed, false) && dlopen(module_path.c_str(), RTLD_NOW) == nullptr) fail("dlopen");
  }
  _exit(0);
}

}  // namespace

// The C library's start of a program, which would call main.
extern "C" int __libc_start_main(Main main, int argc, char** argv, void (*init)(), void (*fini)(),
                                 void (*loader_fini)(), void* stack_end) {
  program_main = main;
  const auto start = reinterpret_cast<StartMain>(dlsym(RTLD_NEXT, "__libc_start_main"));
  return start(std::getenv("FORK_SOCKET") != nullptr ? serve : main, argc, argv, init, fini, loader_fini, stack_end);
}
