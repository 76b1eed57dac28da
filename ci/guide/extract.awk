# SPDX-License-Identifier: MIT
# Turns a guide in Markdown into what can be run. Two markers, each directly above its block, say what a block is:
#   <!-- run -->         ```sh commands of the session that a reader has on a machine of their own
#   <!-- file: NAME -->  a file in the session's folder, there from here on
# A block of commands without a marker is an error: whatever a guide tells its readers to type is run.
#
# Usage: awk -v out=FOLDER -f extract.awk PAGE...    (FOLDER/0/files must be there for the first one, and so on)
# Writes FOLDER/0/session, shell code in which every command has the line number that it has in the first page;
# FOLDER/0/files/LINE; and FOLDER/0/session.plan, what will be done in words; and so on for the others. None of them
# needs a command, as long as one has.

function fail(line, what) {
  print name ":" line ": " what >"/dev/stderr"
  failed = 1
  exit 1
}

function plan(what, detail) { print name ":" FNR ": " what ": " detail >(folder "/session.plan") }

function end_page() {
  if (in_fence) fail(in_fence, "a block without an end")
  if (kind != "") fail(marker_line, "a marker stands directly above its block")
}

function read_marker() {
  if ($0 == "<!-- run -->") kind = "session"
  else if ($0 ~ /^<!-- file: [A-Za-z0-9_.\/-]+ -->$/) {
    kind = "file"
    file = $3
    if (file ~ /^\/|(^|\/)\.\.(\/|$)|\/$/) fail(FNR, "a file's name stays in the session's folder: " file)
  } else fail(FNR, "no such marker: " $0)
  marker_line = FNR
}

function open_fence(language) {
  if ($0 !~ /^```[^`]*$/) fail(FNR, "a fence is three backticks at the start of a line")
  language = substr($0, 4)
  sub(/[ \t].*/, "", language)
  if (kind == "" && language ~ /^(sh|bash|zsh|shell|console)$/)
    fail(FNR, "commands without a marker: <!-- run --> or <!-- file: NAME -->")
  if (kind == "session" && language != "sh") fail(FNR, "what is run is written as ```sh")
  if (kind == "file") {
    target = "\"$guide_folder/" file "\""
    session = "mkdir -p \"$(dirname " target ")\"; cp \"$guide_files/" FNR "\" " target
    target = folder "/files/" FNR
    printf "" >target
    plan("file", file)
  }
  in_fence = FNR
}

function close_fence() {
  if (kind == "file") close(target)
  in_fence = continued = 0
  kind = ""
}

function read_command() {
  if (!continued && $0 !~ /^[ \t]*(#.*)?$/) plan("run", $0)
  continued = $0 ~ /\\$/
}

FNR == 1 {
  end_page()
  name = FILENAME
  folder = out "/" number++
}

{
  session = ""
  if (in_fence) {
    if ($0 == "```") close_fence()
    else if (kind == "file") print >target
    else if (kind == "session") { session = $0; read_command(); commands++ }
  } else if ($0 ~ /^[ \t>]*(```|~~~)/) open_fence()
  else if (kind != "") fail(marker_line, "a marker stands directly above its block")
  else if (tolower($0) ~ /^[ \t]*<!--[ \t]*(run|file)[^a-z]/) read_marker()
  print session >(folder "/session")
}

END {
  if (failed) exit 1
  end_page()
  if (!commands) fail(FNR, "a guide without a command")
}
