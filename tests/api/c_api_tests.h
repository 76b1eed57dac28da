// SPDX-License-Identifier: MIT
#pragma once

// The tests that c_api_test runs, in this order: they share their random numbers.

void names_of_all_enumerators_and_of_no_other_value(void);
void the_library_tells_what_it_is(void);
void the_layout_of_structs_is_that_of_the_first_version(void);
void init_sets_the_defaults(void);
void init_takes_older_sizes_and_marks_what_it_refuses(void);
void select_takes_older_options_and_refuses_sizes_that_are_none(void);
void a_store_counts_what_it_holds(void);
void what_cannot_be_created_is_told_and_null(void);
void null_is_refused_everywhere(void);
void blocks_are_made_of_matches(void);
void blocks_are_made_for_any_camera(void);
void a_frame_is_selected_from_and_judged(void);
void whatever_is_refused_all_usable_matches_are_selected(void);
void active_matching_selects_what_is_found(void);
void no_good_features_are_refused(void);
void selections_answer_and_name_errors(void);
void active_selection_proposes_and_takes_answers(void);
void active_selection_proposes_batches(void);
void a_start_that_is_refused_ends_what_was_under_way(void);
