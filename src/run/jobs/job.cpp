#include "noiseloom/run/job.h"

namespace noiseloom {

std::unique_ptr<Job> make_job(const RunConfig& config) {
  switch (config.optimizer.method) {
    case Method::void_and_cluster:
      return make_order_job(config);
    case Method::construct:
      return make_construct_job(config);
    default:
      return make_swap_job(config);
  }
}

}  // namespace noiseloom
