// SPDX-License-Identifier: MIT
#include <maxlogdet/tbb.h>
#include <maxlogdet/tbb.hpp>

namespace {

// A TbbExecutor has no state: any instance will do.
int32_t concurrency(void* /*user_data*/) { return maxlogdet::TbbExecutor().concurrency(); }

void run(void* /*user_data*/, int32_t workers, maxlogdet_body body, void* context) {
  maxlogdet::TbbExecutor().run(workers, body, context);
}

}  // namespace

maxlogdet_error maxlogdet_tbb_executor_init(maxlogdet_executor* executor, size_t struct_size) {
  const maxlogdet_error error = maxlogdet_executor_init(executor, struct_size);
  if (error != MAXLOGDET_ERROR_NONE) return error;
  if (struct_size < offsetof(maxlogdet_executor, run) + sizeof executor->run) {
    executor->struct_size = 0;
    return MAXLOGDET_ERROR_INVALID_ARGUMENT;
  }
  executor->concurrency = concurrency;
  executor->run = run;
  return MAXLOGDET_ERROR_NONE;
}
