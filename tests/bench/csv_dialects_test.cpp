// SPDX-License-Identifier: MIT
// Frame files as pandas, R and spreadsheets write them.
#include "bench/world/csv.hpp"
#include "tests/bench/frame_files.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <utility>

namespace maxlogdet::test {
namespace {

using Fields = std::vector<std::string>;

std::string joined(const Fields& fields, char separator) {
  std::string text;
  for (const std::string& field : fields) text += separator + field;
  return text.substr(1);
}

TEST(Csv, splits_at_separators_outside_of_quotes) {
  EXPECT_EQ(sim::split_csv("1, b ,,\"c,d\", \"e \"\"f\"\"\" ,", ','), (Fields{"1", "b", "", "c,d", "e \"f\"", ""}));
  EXPECT_EQ(sim::split_csv("\t1\t\t2 \t", '\t'), (Fields{"", "1", "", "2", ""}));
  EXPECT_EQ(sim::split_csv("a 5\" disk,b", ','), (Fields{"a 5\" disk", "b"}));
  EXPECT_EQ(sim::split_csv("", ','), (Fields{""}));
}

TEST(Csv, finds_the_separator) {
  EXPECT_EQ(sim::separator_of("a,b"), ',');
  EXPECT_EQ(sim::separator_of("a"), ',');
  EXPECT_EQ(sim::separator_of("1,5;2,5"), ';');
  EXPECT_EQ(sim::separator_of("1,5\t2,5"), '\t');
  EXPECT_EQ(sim::separator_of("1,\t2 ,\t 3"), ',') << "the tabs are blanks";
  EXPECT_EQ(sim::separator_of("\"a;b\",\"c\td\",e"), ',');
}

TEST(Csv, reads_decimal_commas_where_commas_do_not_separate) {
  EXPECT_EQ(sim::split_csv("1,5;-2,5e-3;\"0,5\";1.234,5;1,234,5;fx,fy", ';'),
            (Fields{"1.5", "-2.5e-3", "0.5", "1.234,5", "1,234,5", "fx,fy"}));
  EXPECT_EQ(sim::split_csv("\"1,5\",2", ','), (Fields{"1,5", "2"})) << "perhaps 15 or 1500";
}

std::vector<double> numbers_of(const sim::Match& match) {
  return {match.point[0], match.point[1], match.point[2],   match.u,         match.v,
          match.u_right,  match.depth,    match.inv_sigma2, match.desc_dist, static_cast<double>(match.octave)};
}

std::vector<std::int64_t> integers_of(const sim::Match& match) {
  return {match.map_point_id, match.keypoint, match.keyframe, match.is_selected ? 1 : 0, match.camera_id};
}

void expect_same_frame(const sim::Frame& a, const sim::Frame& b) {
  ASSERT_EQ(a.matches.size(), b.matches.size());
  for (std::size_t i = 0; i < a.matches.size(); ++i) {
    EXPECT_EQ(numbers_of(a.matches[i]), numbers_of(b.matches[i])) << i;
    EXPECT_EQ(integers_of(a.matches[i]), integers_of(b.matches[i])) << i;
  }
  EXPECT_EQ(a.camera.fx, b.camera.fx);
  EXPECT_EQ(a.camera.bf, b.camera.bf);
  EXPECT_EQ(a.T_cw_prior, b.T_cw_prior);
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.has_quality, b.has_quality);
  EXPECT_EQ(a.has_selection, b.has_selection);
  ASSERT_EQ(a.map_covariances.size(), b.map_covariances.size());
  for (std::size_t i = 0; i < a.map_covariances.size(); ++i) {
    if (std::isnan(b.map_covariances[i][0])) {
      EXPECT_TRUE(std::isnan(a.map_covariances[i][0])) << i;
    } else {
      EXPECT_EQ(a.map_covariances[i], b.map_covariances[i]) << i;
    }
  }
}

class CsvDialects : public FrameFiles {
 protected:
  const Lines comments = {"# fx,fy,cx,cy,bf: 458.5,457,367,248,50", "# Tcw_prior: 1,0,0,0.5,0,1,0,0,0,0,1,0"};

  std::string write_text(const std::string& text) const {
    std::ofstream(path("frame_007.csv"), std::ios::binary) << text;
    return path("frame_007.csv");
  }
  sim::Frame read_text(const std::string& text) const { return sim::read_frame(write_text(text)); }
  sim::Frame read_rows(const Lines& rows) const {
    Lines lines = comments;
    lines.insert(lines.end(), rows.begin(), rows.end());
    return read(lines);
  }
  void expect_refused_row(const std::string& header, const std::string& row, const std::string& expected) const {
    expect_error({comments[0], comments[1], header, row}, ":4: ", expected);
  }
};

TEST_F(CsvDialects, comments_may_be_cells_of_a_spreadsheet) {
  const std::string rows = "mp_id;X;Y;Z;u;v\n1;0,5;0;5;367;248\n";
  for (const std::string& camera : {std::string("\"# fx,fy,cx,cy,bf: 458.5,457,367,248,50\";;;;;"),
                                    std::string("# fx;fy;cx;cy;bf: 458.5;457;367;248;50;"),
                                    std::string("\"# fx\";fy;cx;cy;\"bf: 458,5\";457,0;\"367\";248;50"),
                                    std::string("# fx,fy,cx,cy,bf: 458.5,457,367,248,50,,,"),
                                    std::string("# fx\tfy\tcx\tcy\tbf: 458,5\t457\t367\t248\t50\t")}) {
    const sim::Frame frame = read_text(camera + "\n" + comments[1] + ";;;\n;;;;;;\n" + rows);
    EXPECT_EQ(frame.camera.fx, 458.5) << camera;
    EXPECT_EQ(frame.camera.bf, 50) << camera;
    EXPECT_EQ(frame.T_cw_prior[3], 0.5);
    ASSERT_EQ(frame.matches.size(), 1U);
    EXPECT_EQ(frame.matches[0].point[0], 0.5);
  }
}

TEST_F(CsvDialects, missing_values_are_those_of_missing_columns) {
  for (const char* const marker :
       {"", "NA", "NaN", "nan", "null", "NULL", "None", "\"\"", " N/A ", "#N/A", "-nan", "nan(ind)"}) {
    SCOPED_TRACE(marker);
    std::string row = "7,1,2,3,4,5";
    for (int i = 0; i < 14; ++i) row += std::string(",") + marker;
    const std::string header =
        "mp_id,X,Y,Z,u,v,kp,octave,u_right,inv_sigma2,desc_dist,depth,cov_xx,cov_xy,cov_xz,cov_yy,cov_yz,cov_zz,"
        "keyframe,selected";
    const sim::Frame frame = read_rows({header, row, row});
    EXPECT_FALSE(frame.has_quality) << "a missing distance is not the best one";
    expect_same_frame(frame, read_rows({"mp_id,X,Y,Z,u,v", "7,1,2,3,4,5", "7,1,2,3,4,5"}));
    for (const char* const column : {"mp_id", "X", "Y", "Z", "u", "v"}) {
      Fields values = {"7", "1", "2", "3", "4", "5"};
      const Fields names = {"mp_id", "X", "Y", "Z", "u", "v"};
      values[static_cast<std::size_t>(std::find(names.begin(), names.end(), column) - names.begin())] = marker;
      expect_refused_row("mp_id,X,Y,Z,u,v", joined(values, ','), std::string(" for ") + column);
    }
  }
  expect_refused_row("mp_id,X,Y,Z,u,v,cov_xx,cov_xy,cov_xz,cov_yy,cov_yz,cov_zz", "7,1,2,3,4,5,1,0,0,1,,1",
                     "for cov_yz");
}

TEST_F(CsvDialects, columns_without_a_known_name_may_hold_text) {
  const sim::Frame frame =
      read_rows({"\"\",mp_id,image,X,Y,Z,u,v,n_obs", "\"r1\",7,\"a \"\"b\"\",c.png\",1,2,3,4,5,x"});
  EXPECT_EQ(frame.unknown_columns, (Fields{"image"})) << "the index is not misspelt";
  EXPECT_EQ(frame.matches[0].point[0], 1);
}

TEST_F(CsvDialects, rows_may_begin_with_what_looks_like_a_comment) {
  const sim::Frame frame = read_rows({"note,mp_id,X,Y,Z,u,v", "#REF!,1,2,3,4,5,6", "\"#12\",2,2,3,4,5,6", "# a comment",
                                      "# one, with, some, commas, in, it, at all", "#ff0000,3,2,3,4,5,6",
                                      "# Tcw_true: 1,0,0,0,0,1,0,0,0,0,1,0", ",4,2,3,4,5,6"});
  ASSERT_EQ(frame.matches.size(), 4U);
  EXPECT_EQ(frame.matches[1].map_point_id, 2);
  expect_refused_row("mp_id,X,Y,Z,u,v", "#REF!,1,2,3,4,5", "an integer for mp_id, not '#REF!'");
}

TEST_F(CsvDialects, a_header_may_be_a_comment_and_the_first_line_name_the_separator) {
  for (const std::string& header : {std::string("# mp_id,X,Y,Z,u,v"), std::string("#mp_id,X,Y,Z,u,v")}) {
    const sim::Frame frame = read_rows({header, "1.000000000000000000e+00,+2,3,4,5,6"});
    ASSERT_EQ(frame.matches.size(), 1U);
    EXPECT_EQ(frame.matches[0].map_point_id, 1);
    EXPECT_EQ(frame.matches[0].point[0], 2);
  }
  EXPECT_EQ(read_text("sep=;\n" + comments[0] + "\n" + comments[1] + "\nmp_id;X;Y;Z;u;v\n1;2;3;4;5;6\n").matches.size(),
            1U);
}

TEST_F(CsvDialects, numbers_and_truths_have_several_spellings) {
  const std::string header = "mp_id,X,Y,Z,u,v,octave,selected";
  const sim::Frame frame = read_rows({header, "1.0,1,2,3,4,5,2.0,True", "1e3,1,2,3,4,5,0,FALSE",
                                      "-0.5e1,1,2,3,4,5,0,1.0", "9007199254740993,1,2,3,4,5,0,false"});
  EXPECT_EQ(frame.matches[0].map_point_id, 1);
  EXPECT_EQ(frame.matches[0].octave, 2);
  EXPECT_EQ(frame.matches[1].map_point_id, 1000);
  EXPECT_EQ(frame.matches[2].map_point_id, -5);
  EXPECT_EQ(frame.matches[3].map_point_id, 9007199254740993);
  const bool selected[] = {true, false, true, false};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(frame.matches[i].is_selected, selected[i]) << i;
  EXPECT_TRUE(frame.has_selection);
  for (const char* const id : {"1.5", "1e300", "9007199254740993.0", "0x10", "True"}) {
    expect_refused_row(header, std::string(id) + ",1,2,3,4,5,0,1",
                       "an integer for mp_id, not '" + std::string(id) + "'");
  }
  expect_refused_row(header, "1,1,2,3,4,5,0,0.5", "0 or 1 for selected, not '0.5'");
}

TEST_F(CsvDialects, names_what_it_does_not_read) {
  expect_refused_row("mp_id,X,Y,Z,u,v", "r1,7,1,2,3,4,5", "6 fields as in the header, not 7 (of R: write.csv");
  expect_refused_row("mp_id,X,Y,Z,u,v", "7,\"1,5\",2,3,4,5", "a finite number for X, not '1,5'");
  expect_refused_row("mp_id;X;Y;Z;u;v", "7;1.234,5;2;3;4;5", "a finite number for X, not '1.234,5'");
  expect_error({comments[0], comments[1], "mp_id X Y Z u v"}, ":3: ", "'mp_id' is missing");
  std::string utf16 = "\xFF\xFE";
  for (const char c : std::string("# fx\n")) utf16 += std::string{c, '\0'};
  for (const std::string& text : {utf16, utf16.substr(2)}) {
    const std::string file = write_text(text);
    expect_input_error([&] { sim::read_frame(file); }, file + ":1: ", "UTF-16 or binary data; save as UTF-8");
  }
  for (const std::string& text : {std::string(70000, 'x'), std::string(70000, ' ') + "\n"}) {
    const std::string file = write_text("\n" + text);
    expect_input_error([&] { sim::read_frame(file); }, file + ":2: ", "a line of at most 65536 bytes");
  }
}

TEST_F(CsvDialects, endless_files_end_in_an_error) {
  expect_input_error([] { sim::read_frame("/dev/zero"); }, "/dev/zero:1: ", "a line of at most 65536 bytes");
  expect_input_error([] { sim::read_frame("/dev/urandom"); }, "/dev/urandom:", "expected");
}

// A value, how files of plain numbers write it, and what else means the same.
struct Value {
  std::string plain;
  Fields others;
};

std::string printed(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

Value real(double value) { return {printed("%.17g", value), {printed("%.17e", value), printed("%.18g", value)}}; }
Value whole(int value) { return {std::to_string(value), {std::to_string(value) + ".0", printed("%.6e", value)}}; }
Value truth(bool value) {
  return value ? Value{"1", {"True", "TRUE", "true", "1.0"}} : Value{"0", {"False", "FALSE", "false", "0.0"}};
}
Value missing() { return {"", {"NA", "NaN", "nan", "null"}}; }

using Row = std::vector<Value>;

const Fields names = {"mp_id",  "X",       "Y",          "Z",        "u",         "v",       "kp",
                      "octave", "u_right", "inv_sigma2", "cov_xx",   "cov_xy",    "cov_xz",  "cov_yy",
                      "cov_yz", "cov_zz",  "camera",     "keyframe", "desc_dist", "selected"};

Row random_row(Random& random) {
  Row row = {whole(random.integer(-100, 100000))};
  for (int i = 0; i < 5; ++i) row.push_back(real(random.uniform(-1, 1) * std::exp2(random.integer(-30, 30))));
  const auto perhaps = [&](const Value& value) { return random.chance(0.2) ? missing() : value; };
  row.push_back(perhaps(whole(random.integer(0, 5000))));
  row.push_back(perhaps(whole(random.integer(0, 7))));
  row.push_back(perhaps(real(random.uniform(-1, 700))));
  row.push_back(perhaps(real(random.uniform(0.1, 1))));
  const bool has_covariance = random.chance(0.5);
  for (const double most : {1.0, 0.1, 0.1, 1.0, 0.1, 1.0}) {
    row.push_back(has_covariance ? real(random.uniform(0, most)) : missing());
  }
  row.push_back(perhaps(whole(0)));
  row.push_back(perhaps(whole(random.integer(-1, 50))));
  row.push_back(random.chance(0.02) ? missing() : real(random.uniform(0, 100)));
  row.push_back(random.chance(0.02) ? missing() : truth(random.chance(0.5)));
  return row;
}

// How a file is written.
class Dialect {
 public:
  explicit Dialect(Random& random)
      : random_(random),
        separator_(",;\t"[random.index(3)]),
        has_decimal_comma_(separator_ != ',' && random.chance(0.5)),
        quoted_(random.integer(0, 2) * 0.5),
        has_index_(random.chance(0.5)),
        has_text_(random.chance(0.5)),
        is_spaced_(random.chance(0.3)),
        line_end_(std::vector<std::string>{"\n", "\r\n", "\r"}[random.index(3)]),
        order_(names.size()) {
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    for (std::size_t i = order_.size(); i > 1; --i) std::swap(order_[i - 1], order_[random.index(i)]);
  }

  std::string text_of(const Lines& comments, const std::vector<Row>& rows) {
    std::string text = random_.chance(0.3) ? "\xEF\xBB\xBF" : "";
    for (const std::string& comment : comments) text += written(comment) + line_end_;
    Fields header;
    for (const std::size_t column : order_) header.push_back(field(names[column]));
    text += line_of(header, "\"\"", "image");
    for (const Row& row : rows) {
      Fields fields;
      for (const std::size_t column : order_) fields.push_back(field(spelt(row[column])));
      text += line_of(fields, std::to_string(text.size()), "\"a" + std::string(1, separator_) + " \"\"b\"\".png\"");
    }
    if (random_.chance(0.5)) text += trailing() + line_end_;
    return text;
  }

 private:
  std::string spelt(const Value& value) {
    const std::size_t which = random_.index(value.others.size() + 1);
    std::string text = which == 0 ? value.plain : value.others[which - 1];
    if (has_decimal_comma_) std::replace(text.begin(), text.end(), '.', ',');
    return text;
  }

  std::string field(const std::string& text) {
    const std::string quote = random_.chance(quoted_) ? "\"" : "";
    return spaces() + quote + spaces() + text + spaces() + quote + spaces();
  }

  std::string spaces() { return is_spaced_ ? std::string(random_.index(3), ' ') : ""; }
  std::string trailing() { return std::string(random_.index(4), separator_); }

  std::string line_of(Fields fields, const std::string& index, const std::string& text) {
    if (has_index_) fields.insert(fields.begin(), index);
    if (has_text_) fields.push_back(text);
    return joined(fields, separator_) + trailing() + line_end_;
  }

  // As it is, as one cell of a spreadsheet, or as several.
  std::string written(const std::string& comment) {
    const std::size_t kind = random_.index(3);
    if (kind == 0) return comment;
    if (kind == 1) return "\"" + comment + "\"" + trailing();
    std::string cells = comment;
    if (has_decimal_comma_) cells = replaced(replaced(cells, ',', separator_), '.', ',');
    return replaced(cells, ',', has_decimal_comma_ ? ',' : separator_) + trailing();
  }

  static std::string replaced(std::string text, char from, char to) {
    std::replace(text.begin(), text.end(), from, to);
    return text;
  }

  Random& random_;
  char separator_;
  bool has_decimal_comma_;
  double quoted_;  // share of fields
  bool has_index_, has_text_, is_spaced_;
  std::string line_end_;
  std::vector<std::size_t> order_;  // of the columns
};

TEST_F(CsvDialects, all_read_to_the_same_frame) {
  for (std::uint64_t repetition = 0; repetition < 300; ++repetition) {
    TracedRandom random(repetition);
    Lines lines = {"# camera (as given): pinhole,458.654,457.25,367.215,248.375", "# image width,height: 752,480",
                   "# Tcw_prior (3x4 row-major, world to camera): 0,-1,0,0.5,1,0,0,-1.25,0,0,1,2e-3"};
    if (random.chance(0.5)) lines[0] = "# fx,fy,cx,cy,bf: 458.654,457.25,367.215,248.375,50.5";
    std::vector<Row> rows;
    for (int i = random.integer(1, 20); i > 0; --i) rows.push_back(random_row(random));
    const std::string text = Dialect(random).text_of(lines, rows);
    SCOPED_TRACE(text);
    lines.push_back(joined(names, ','));
    for (const Row& row : rows) {
      Fields fields;
      for (const Value& value : row) fields.push_back(value.plain);
      lines.push_back(joined(fields, ','));
    }
    const sim::Frame plain = read(lines);
    ASSERT_NO_THROW(expect_same_frame(read_text(text), plain));
    if (HasFailure()) return;
  }
}

}  // namespace
}  // namespace maxlogdet::test
