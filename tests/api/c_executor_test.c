// SPDX-License-Identifier: MIT
// Executors written in C: none of them changes the answer, whatever threads it has.
#define _POSIX_C_SOURCE 200809L  // NOLINT(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp): for pthread.h

#include "tests/api/c_check.h"

#include <pthread.h>
#if defined(MAXLOGDET_WITH_TBB)
#include <maxlogdet/tbb.h>
#endif

enum { n = 3000, helpers = 2 };

// Helpers that wait for work, for one caller at a time.
struct pool {
  pthread_mutex_t mutex;
  pthread_cond_t changed;
  pthread_t threads[helpers];
  maxlogdet_body body;
  void* context;
  int32_t next, end, running, helped, runs, workers;
  int is_over;
};

static void* serve(void* given) {
  struct pool* const pool = given;
  pthread_mutex_lock(&pool->mutex);
  for (;;) {
    while (!pool->is_over && pool->next >= pool->end) pthread_cond_wait(&pool->changed, &pool->mutex);
    if (pool->is_over) break;
    const maxlogdet_body body = pool->body;
    void* const context = pool->context;
    const int32_t worker = pool->next++;
    ++pool->running;
    ++pool->helped;
    pthread_mutex_unlock(&pool->mutex);
    body(context, worker);
    pthread_mutex_lock(&pool->mutex);
    if (--pool->running == 0) pthread_cond_broadcast(&pool->changed);
  }
  pthread_mutex_unlock(&pool->mutex);
  return NULL;
}

static int32_t pool_concurrency(void* user_data) {
  (void)user_data;
  return helpers + 1;
}

static void pool_run(void* user_data, int32_t workers, maxlogdet_body body, void* context) {
  struct pool* const pool = user_data;
  pthread_mutex_lock(&pool->mutex);
  ++pool->runs;
  pool->workers = workers;
  pool->body = body;
  pool->context = context;
  pool->next = 1;
  pool->end = workers;
  pthread_cond_broadcast(&pool->changed);
  pthread_mutex_unlock(&pool->mutex);
  body(context, 0);
  pthread_mutex_lock(&pool->mutex);
  pool->end = 0;  // no worker starts any more
  while (pool->running > 0) pthread_cond_wait(&pool->changed, &pool->mutex);
  pthread_mutex_unlock(&pool->mutex);
}

static void start_pool(struct pool* pool) {
  memset(pool, 0, sizeof *pool);
  REQUIRE(pthread_mutex_init(&pool->mutex, NULL) == 0 && pthread_cond_init(&pool->changed, NULL) == 0);
  for (int i = 0; i < helpers; ++i) REQUIRE(pthread_create(&pool->threads[i], NULL, serve, pool) == 0);
}

static int32_t times_helped(struct pool* pool) {
  pthread_mutex_lock(&pool->mutex);
  const int32_t helped = pool->helped;
  pthread_mutex_unlock(&pool->mutex);
  return helped;
}

static void end_pool(struct pool* pool) {
  pthread_mutex_lock(&pool->mutex);
  pool->is_over = 1;
  pthread_cond_broadcast(&pool->changed);
  pthread_mutex_unlock(&pool->mutex);
  for (int i = 0; i < helpers; ++i) pthread_join(pool->threads[i], NULL);
  pthread_cond_destroy(&pool->changed);
  pthread_mutex_destroy(&pool->mutex);
}

// With every strategy, the answer of a selector without an executor; `threads` as the selection tells them.
static void check_answers(const maxlogdet_executor* given, int32_t threads) {
  maxlogdet_block_store* const blocks = random_blocks(n);
  maxlogdet_executor executor = *given;
  maxlogdet_selector* alone = NULL;
  maxlogdet_selector* helped = NULL;
  REQUIRE(maxlogdet_selector_create(n, NULL, &alone) == MAXLOGDET_ERROR_NONE);
  REQUIRE(maxlogdet_selector_create(n, &executor, &helped) == MAXLOGDET_ERROR_NONE);
  memset(&executor, 0xA5, sizeof executor);  // it was copied
  for (maxlogdet_strategy strategy = 0; strcmp(maxlogdet_strategy_name(strategy), "unknown") != 0; ++strategy) {
    maxlogdet_options options = default_options();
    options.budget = 100;
    options.strategy = strategy;
    options.threads = 16;
    const maxlogdet_selection* const answer = maxlogdet_selector_select(helped, blocks, &options);
    const maxlogdet_selection* const expected = maxlogdet_selector_select(alone, blocks, &options);
    CHECK(answer->status == MAXLOGDET_STATUS_OK && answer->size == 100);
    CHECK(same_answer(answer, expected));
    CHECK(answer->threads == threads && expected->threads == 1);
  }
  maxlogdet_selector_destroy(helped);
  maxlogdet_selector_destroy(alone);
  maxlogdet_block_store_destroy(blocks);
}

// What is made of points: blocks, and what a selector and good features select of them; `help` may be null. Returns the
// answer of that selector.
static const maxlogdet_selection* check_frame(const double* points, const maxlogdet_executor* help,
                                              maxlogdet_selector* selector) {
  maxlogdet_camera camera;
  maxlogdet_matches matches;
  maxlogdet_match match;
  maxlogdet_block_options block_options;
  maxlogdet_camera_init(&camera, sizeof camera);
  maxlogdet_matches_init(&matches, sizeof matches);
  maxlogdet_match_init(&match, sizeof match);
  maxlogdet_block_options_init(&block_options, sizeof block_options);
  camera.fx = camera.fy = 450;
  matches.size = n;
  matches.points = points;
  maxlogdet_options options = default_options();
  options.threads = block_options.threads = 16;
  maxlogdet_block_store* blocks = NULL;
  maxlogdet_good_features* good = NULL;
  REQUIRE(maxlogdet_block_store_create(n, &blocks) == MAXLOGDET_ERROR_NONE);
  REQUIRE(maxlogdet_good_features_create(n, help, &good) == MAXLOGDET_ERROR_NONE);
  CHECK(maxlogdet_append_blocks(&camera, identity_pose, &matches, &block_options, blocks, help)->appended == n);
  CHECK(maxlogdet_good_features_start(good, &camera, identity_pose) == MAXLOGDET_ERROR_NONE);
  for (size_t i = 0; i < n; ++i) {
    memcpy(match.point, &points[3 * i], sizeof match.point);
    CHECK(maxlogdet_good_features_add(good, &match) == MAXLOGDET_ERROR_NONE);
  }
  const maxlogdet_selection* const of_frame = maxlogdet_good_features_select(good, &options);
  const maxlogdet_selection* const of_blocks = maxlogdet_selector_select(selector, blocks, &options);
  CHECK(of_frame->status == MAXLOGDET_STATUS_OK && (of_frame->threads > 1) == (help != NULL));
  CHECK(same_answer(of_blocks, of_frame));
  maxlogdet_good_features_destroy(good);
  maxlogdet_block_store_destroy(blocks);
  return of_blocks;
}

// They are the same with its help.
static void check_frames(const maxlogdet_executor* executor) {
  static double points[3 * n];
  for (size_t e = 0; e < 3 * n; ++e) points[e] = 3 * random_entry() + (e % 3 == 2 ? 5 : 0);
  maxlogdet_selector* selectors[2];
  const maxlogdet_selection* answers[2];
  for (int i = 0; i < 2; ++i) {
    REQUIRE(maxlogdet_selector_create(n, NULL, &selectors[i]) == MAXLOGDET_ERROR_NONE);
    answers[i] = check_frame(points, i == 0 ? NULL : executor, selectors[i]);
  }
  CHECK(same_answer(answers[0], answers[1]));
  for (int i = 0; i < 2; ++i) maxlogdet_selector_destroy(selectors[i]);
}

int main(void) {
  struct pool pool;
  start_pool(&pool);
  maxlogdet_executor executor;
  REQUIRE(maxlogdet_executor_init(&executor, sizeof executor) == MAXLOGDET_ERROR_NONE);
  executor.concurrency = pool_concurrency;
  executor.run = pool_run;
  executor.user_data = &pool;
  check_answers(&executor, helpers + 1);
  CHECK(pool.runs == 6 && pool.workers == helpers + 1);
  check_frames(&executor);
  CHECK(pool.runs > 7);                                         // for blocks, and for what good features do
  for (int i = 0; i < 1000 && times_helped(&pool) < 10; ++i) {  // on a busy machine helpers come late, or not at all
    check_answers(&executor, helpers + 1);
    check_frames(&executor);
  }
  CHECK(times_helped(&pool) >= 10);
  end_pool(&pool);

#if defined(MAXLOGDET_WITH_TBB)
  const size_t wrong_sizes[] = {sizeof executor + 8, offsetof(maxlogdet_executor, run)};
  CHECK(maxlogdet_tbb_executor_init(NULL, sizeof executor) == MAXLOGDET_ERROR_INVALID_ARGUMENT);
  for (int i = 0; i < 2; ++i) {
    CHECK(maxlogdet_tbb_executor_init(&executor, wrong_sizes[i]) == MAXLOGDET_ERROR_INVALID_ARGUMENT);
    CHECK(executor.struct_size == 0);
  }
  CHECK(maxlogdet_tbb_executor_init(&executor, sizeof executor) == MAXLOGDET_ERROR_NONE);
  const int32_t slots = executor.concurrency(executor.user_data);
  CHECK(slots >= 1);
  check_answers(&executor, slots < 16 ? slots : 16);
  if (slots > 1) check_frames(&executor);
#endif
  return report();
}
