// SPDX-License-Identifier: MIT
// The C API as C99 sees it: every function, what is refused, and what may never change. That its answers are those of
// C++ is for c_api_equals_cpp_test.cpp to say.
#include "tests/api/c_api_tests.h"
#include "tests/api/c_check.h"

int main(void) {
  names_of_all_enumerators_and_of_no_other_value();
  the_library_tells_what_it_is();
  the_layout_of_structs_is_that_of_the_first_version();
  init_sets_the_defaults();
  init_takes_older_sizes_and_marks_what_it_refuses();
  select_takes_older_options_and_refuses_sizes_that_are_none();
  a_store_counts_what_it_holds();
  what_cannot_be_created_is_told_and_null();
  null_is_refused_everywhere();
  blocks_are_made_of_matches();
  blocks_are_made_for_any_camera();
  a_frame_is_selected_from_and_judged();
  whatever_is_refused_all_usable_matches_are_selected();
  active_matching_selects_what_is_found();
  no_good_features_are_refused();
  selections_answer_and_name_errors();
  active_selection_proposes_and_takes_answers();
  active_selection_proposes_batches();
  a_start_that_is_refused_ends_what_was_under_way();
  return report();
}
