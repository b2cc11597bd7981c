// Filters in one line.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "noiseloom/problem/spec.h"

namespace noiseloom::testing_support {

inline KernelSpec kernel_of(KernelKind kind) {
  KernelSpec kernel;
  kernel.kind = kind;
  return kernel;
}
inline KernelSpec box(int size) {
  KernelSpec kernel = kernel_of(KernelKind::box);
  kernel.size = size;
  return kernel;
}
inline KernelSpec gauss(double sigma) {
  KernelSpec kernel = kernel_of(KernelKind::gauss);
  kernel.sigma = sigma;
  return kernel;
}
inline KernelSpec gauss_energy(double sigma) {
  KernelSpec kernel = kernel_of(KernelKind::gauss_energy);
  kernel.sigma = sigma;
  return kernel;
}
inline KernelSpec binomial(int n) {
  KernelSpec kernel = kernel_of(KernelKind::binomial);
  kernel.n = n;
  return kernel;
}
inline KernelSpec ema(double alpha, double beta) {
  KernelSpec kernel = kernel_of(KernelKind::ema);
  kernel.alpha = alpha;
  kernel.rejection = beta;
  return kernel;
}
inline KernelSpec table(const std::string& file) {
  KernelSpec kernel = kernel_of(KernelKind::table);
  kernel.file = file;
  return kernel;
}

inline GroupSpec group(std::vector<int> axes, KernelSpec kernel, double weight = 0) {
  return {std::move(axes), std::move(kernel), weight};
}
inline FilterSpec product(std::vector<GroupSpec> groups) { return {Combine::product, std::move(groups)}; }
inline FilterSpec sum(std::vector<GroupSpec> groups) { return {Combine::sum, std::move(groups)}; }

}  // namespace noiseloom::testing_support
