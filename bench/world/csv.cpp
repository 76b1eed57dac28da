// SPDX-License-Identifier: MIT
#include "bench/world/csv.hpp"

#include "bench/world/text.hpp"

#include <algorithm>
#include <iterator>

namespace maxlogdet::sim {
namespace {

bool is_number_with_comma(std::string_view field) {
  return std::count(field.begin(), field.end(), ',') == 1 &&
         field.find_first_not_of("0123456789,+-eE") == std::string_view::npos;
}

}  // namespace

char separator_of(std::string_view line) {
  bool is_quoted = false, has_tab = false;
  char last = 0;  // that is no blank
  for (const char c : line) {
    if (c == '"') is_quoted = !is_quoted;
    if (is_quoted) continue;
    if (c == ';') return ';';
    has_tab = has_tab || (c == '\t' && last != ',');
    if (c != ' ' && c != '\t') last = c;
  }
  return has_tab ? '\t' : ',';
}

std::vector<std::string> split_csv(std::string_view line, char separator) {
  std::vector<std::string> fields(1);
  bool is_quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (is_quoted && c == '"' && line.substr(i, 2) == "\"\"") {  // a quote within quotes
      fields.back() += line[i++];
    } else if (c == '"' && (is_quoted || trimmed(fields.back()).empty())) {
      is_quoted = !is_quoted;
    } else if (c == separator && !is_quoted) {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  for (std::string& field : fields) {
    field = trimmed(field);
    if (separator != ',' && is_number_with_comma(field)) field[field.find(',')] = '.';
  }
  return fields;
}

std::vector<std::string> split_csv(std::string_view line) { return split_csv(line, separator_of(line)); }

bool is_empty_row(std::string_view line) { return line.find_first_not_of(" \t,;\"") == std::string_view::npos; }

bool is_missing(std::string_view field) {
  constexpr std::string_view markers[] = {"",     "na",       "n/a",       "#n/a", "<na>", "nan",
                                          "-nan", "nan(ind)", "-nan(ind)", "null", "none"};
  return std::find(std::begin(markers), std::end(markers), lower_case(field)) != std::end(markers);
}

}  // namespace maxlogdet::sim
