// The three kinds of failure.
//
// UserError: the input is wrong (config, command line, a file that was handed in). All faults are collected before it
// is thrown; programs print them and exit with 2, nothing started. EnvironmentError: the world failed (disk, MPI,
// HDF5); exit 1. NOISELOOM_CHECK*: the programmer failed; prints both values and aborts.
#pragma once

#include <cstdint>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace noiseloom {

// One thing wrong with the user's input. `where` is "run.toml:14", "command line" or a path; `text` says what was found
// and what is accepted: `texture.size.t = 0: must be at least 1`.
struct Fault {
  std::string where;
  std::string text;
};

class UserError : public std::runtime_error {
 public:
  explicit UserError(std::vector<Fault> faults);
  UserError(std::string where, std::string text) : UserError(std::vector<Fault>{{std::move(where), std::move(text)}}) {}
  const std::vector<Fault>& faults() const { return faults_; }

 private:
  std::vector<Fault> faults_;  // what() is one line each: "where: text"
};

class EnvironmentError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Throws UserError if there are any faults.
void throw_if_any(std::vector<Fault> faults);

// The element of `accepted` nearest to `word` by edit distance, or "" when none is near enough to be a misspelling.
std::string nearest_word(const std::string& word, const std::vector<std::string>& accepted);

namespace detail {
[[noreturn]] void check_failed(const char* file, int line, const char* expression, const std::string& values);
template <class A, class B>
std::string both_values(const A& a, const B& b) {
  std::ostringstream out;
  out << a << " and " << b;
  return out.str();
}
}  // namespace detail
}  // namespace noiseloom

#define NOISELOOM_CHECK(condition) \
  ((condition) ? void(0) : ::noiseloom::detail::check_failed(__FILE__, __LINE__, #condition, ""))
#define NOISELOOM_CHECK_OP(a, op, b)                                                     \
  (((a)op(b)) ? void(0)                                                                  \
              : ::noiseloom::detail::check_failed(__FILE__, __LINE__, #a " " #op " " #b, \
                                                  ::noiseloom::detail::both_values((a), (b))))
#define NOISELOOM_CHECK_EQ(a, b) NOISELOOM_CHECK_OP(a, ==, b)
#define NOISELOOM_CHECK_LT(a, b) NOISELOOM_CHECK_OP(a, <, b)
#define NOISELOOM_CHECK_LE(a, b) NOISELOOM_CHECK_OP(a, <=, b)
