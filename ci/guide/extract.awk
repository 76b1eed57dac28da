# SPDX-License-Identifier: MIT
# Turns a guide in Markdown into what can be run. Three markers, each directly above its block, say what a block is:
#   <!-- run -->            ```sh commands of the session that a reader has on a machine of their own
#   <!-- run: checkout -->  ```sh commands in the project's checkout
#   <!-- file: NAME -->     a file in the session's folder, there from here on
# A block of commands without a marker is an error: whatever a guide tells its readers to type is run.
#
# Usage: awk -v name=NAME_IN_MESSAGES -v out=FOLDER -f extract.awk GUIDE    (FOLDER/files must be there)
# Writes FOLDER/session and FOLDER/checkout, shell code in which every command has the line number that it has in the
# guide; FOLDER/files/LINE; and FOLDER/session.plan and FOLDER/checkout.plan, what will be done in words.

function fail(line, what) {
  print name ":" line ": " what >"/dev/stderr"
  failed = 1
  exit 1
}

function plan(script, what, detail) { print name ":" NR ": " what ": " detail >(out "/" script ".plan") }

function read_marker() {
  if ($0 == "<!-- run -->") kind = "session"
  else if ($0 == "<!-- run: checkout -->") kind = "checkout"
  else if ($0 ~ /^<!-- file: [A-Za-z0-9_.\/-]+ -->$/) {
    kind = "file"
    file = $3
    if (file ~ /^\/|(^|\/)\.\.(\/|$)|\/$/) fail(NR, "a file's name stays in the session's folder: " file)
  } else fail(NR, "no such marker: " $0)
  marker_line = NR
}

function open_fence(language) {
  if ($0 !~ /^```[^`]*$/) fail(NR, "a fence is three backticks at the start of a line")
  language = substr($0, 4)
  sub(/[ \t].*/, "", language)
  if (kind == "" && language ~ /^(sh|bash|zsh|shell|console)$/)
    fail(NR, "commands without a marker: <!-- run -->, <!-- run: checkout --> or <!-- file: NAME -->")
  if ((kind == "session" || kind == "checkout") && language != "sh") fail(NR, "what is run is written as ```sh")
  if (kind == "file") {
    target = "\"$guide_folder/" file "\""
    session = "mkdir -p \"$(dirname " target ")\"; cp \"$guide_files/" NR "\" " target
    target = out "/files/" NR
    printf "" >target
    plan("session", "file", file)
  }
  in_fence = NR
}

function close_fence() {
  if (kind == "file") close(target)
  in_fence = continued = 0
  kind = ""
}

function read_command(script) {
  if (!continued && $0 !~ /^[ \t]*(#.*)?$/) plan(script, script == "session" ? "run" : "run in the checkout", $0)
  continued = $0 ~ /\\$/
}

{
  session = checkout = ""
  if (in_fence) {
    if ($0 == "```") close_fence()
    else if (kind == "file") print >target
    else if (kind == "session") { session = $0; read_command("session"); commands++ }
    else if (kind == "checkout") { checkout = $0; read_command("checkout"); commands++ }
  } else if ($0 ~ /^[ \t>]*(```|~~~)/) open_fence()
  else if (kind != "") fail(marker_line, "a marker stands directly above its block")
  else if (tolower($0) ~ /^[ \t]*<!--[ \t]*(run|file)[^a-z]/) read_marker()
  print session >(out "/session")
  print checkout >(out "/checkout")
}

END {
  if (failed) exit 1
  if (in_fence) fail(in_fence, "a block without an end")
  if (kind != "") fail(marker_line, "a marker stands directly above its block")
  if (!commands) fail(NR, "a guide without a command")
}
