// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/submit.h"

#include <fmt/core.h>

#include <cctype>
#include <cstdio>

#include "sim/base/text.h"

namespace reamsim {

namespace {

constexpr const char* kMark = "Written by reamsim sweep submit";

/// Between the signal and the time limit: time to save checkpoints.
constexpr int kBeforeLimit_s = 60;

/// Variables and functions of the scripts: `run_shard I` and `collect`.
std::string shell_functions(const Submission& s) {
  std::string words;
  for (const std::string& text : s.overrides) words += " --set " + shell_word(text);
  return fmt::format(
      "program={}\n"
      "study={}\n"
      "output={}\n"
      "# A job takes one processor, also on a machine with more.\n"
      "export POCL_MAX_PTHREAD_COUNT=1 POCL_AFFINITY=0\n"
      "run_shard() {{ exec \"$program\" sweep run \"$study\" -o \"$output\" --shard \"$1/{}\" --jobs {}{}; }}\n"
      "collect() {{ \"$program\" sweep collect \"$study\" -o \"$output\"{}; }}\n",
      shell_word(s.program), shell_word(s.study), shell_word(s.output), s.shards, s.jobs, words, words);
}

std::string slurm_array(const Submission& s) {
  return fmt::format(
             "#!/bin/bash\n"
             "# {}: an array task per shard.\n"
             "#SBATCH --job-name={}\n"
             "#SBATCH --array=1-{}\n"
             "#SBATCH --ntasks=1 --cpus-per-task={}\n"
             "#SBATCH --time={}\n"
             "#SBATCH --signal=B:USR1@{}\n"
             "#SBATCH --requeue --open-mode=append\n\n",
             kMark, plain_name(s.name), s.shards, s.jobs, s.time_limit, kBeforeLimit_s) +
         shell_functions(s) +
         "\n"
         "shard=  # the signal may come at once; without a trap it would end this script\n"
         "trap 'signalled=yes; if [ -n \"$shard\" ]; then kill -USR1 \"$shard\"; fi' USR1\n"
         "run_shard \"$SLURM_ARRAY_TASK_ID\" & shard=$!\n"
         "signalled=yes\n"
         "while [ -n \"$signalled\" ]; do  # a signal ends `wait` early\n"
         "  signalled=\n"
         "  wait \"$shard\"; status=$?\n"
         "done\n"
         "# 75: checkpoints are saved, the same command continues. 138: the signal came before the program was ready.\n"
         "if [ \"$status\" -eq 75 ] || [ \"$status\" -eq 138 ]; then scontrol requeue "
         "\"${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID\"; fi\n"
         "exit \"$status\"\n";
}

std::string slurm_collect(const Submission& s) {
  return fmt::format(
             "#!/bin/bash\n"
             "# {}: the table of the study, after its shards.\n"
             "#SBATCH --job-name={}.collect\n"
             "#SBATCH --ntasks=1 --cpus-per-task=1\n"
             "#SBATCH --time={}\n\n",
             kMark, plain_name(s.name), s.time_limit) +
         shell_functions(s) + "\ncollect\n";
}

std::string parallel_script(const Submission& s) {
  return fmt::format(
             "#!/bin/bash\n"
             "# {}: as many shards at a time as the machine has processors for. Run it again to continue.\n\n",
             kMark) +
         shell_functions(s) +
         fmt::format(
             "export program study output SHELL=/bin/bash\n"
             "export -f run_shard\n"
             "\n"
             "at_a_time=$(($(nproc) / {}))\n"
             "parallel --jobs \"$((at_a_time > 0 ? at_a_time : 1))\" run_shard ::: $(seq {})\n"
             "status=$?\n"
             "collect\n"
             "exit \"$status\"\n",
             s.jobs, s.shards);
}

std::string snakefile(const Submission& s) {
  std::string settings;
  for (const std::string& text : s.overrides) settings += ", \"--set\", " + python_literal(text);
  return fmt::format(
      "# {}: a job per shard, then the table.\n"
      "import shlex\n"
      "\n"
      "program = {}\n"
      "study = [{}, \"-o\", {}{}]\n"
      "shards = {}\n"
      "\n"
      "localrules: all, collect\n"
      "\n"
      "rule all:\n"
      "    input: \"collected\"\n"
      "\n"
      "rule shard:\n"
      "    output: touch(\"shards/{{shard}}.done\")\n"
      "    params: command=shlex.join([program, \"sweep\", \"run\", *study, \"--jobs\", \"{}\"])\n"
      "    threads: {}\n"
      "    resources: time=\"{}\"\n"
      "    # Saves checkpoints before the time limit and ends with 75; Snakemake then repeats it, and it continues.\n"
      "    shell:\n"
      "        \"POCL_MAX_PTHREAD_COUNT=1 POCL_AFFINITY=0 timeout --preserve-status -s USR1 {} \"\n"
      "        \"{{params.command}} --shard {{wildcards.shard}}/{}\"\n"
      "\n"
      "rule collect:\n"
      "    input: expand(\"shards/{{shard}}.done\", shard=range(1, shards + 1))\n"
      "    output: touch(\"collected\")\n"
      "    params: command=shlex.join([program, \"sweep\", \"collect\", *study])\n"
      "    shell: \"{{params.command}}\"\n",
      kMark, python_literal(s.program), python_literal(s.study), python_literal(s.output), settings, s.shards, s.jobs,
      s.jobs, s.time_limit, seconds_of_time_limit(s.time_limit) - kBeforeLimit_s, s.shards);
}

std::string snakemake_profile(const Submission& s) {
  return fmt::format(
      "# {}: `snakemake --profile profile` submits to Slurm.\n"
      "cluster: \"sbatch --parsable --job-name={}.{{wildcards}} --ntasks=1 --cpus-per-task={{threads}}"
      " --time={{resources.time}}\"\n"
      "cluster-status: \"./profile/status.sh\"\n"
      "jobs: {}\n"
      "restart-times: 5\n"
      "latency-wait: 60\n",
      kMark, plain_name(s.name), s.shards);
}

/// Without it Snakemake would wait for ever for a job that was killed.
std::string snakemake_status() {
  return fmt::format(
      "#!/bin/sh\n"
      "# {}: tells Snakemake what became of a Slurm job.\n"
      "case \"$(scontrol show job \"$1\" 2>/dev/null | sed -n 's/.*JobState=\\([A-Z_]*\\).*/\\1/p')\" in\n"
      "  PENDING|CONFIGURING|RUNNING|SUSPENDED|COMPLETING|REQUEUED) echo running ;;\n"
      "  COMPLETED) echo success ;;\n"
      "  *) echo failed ;;\n"
      "esac\n",
      kMark);
}

}  // namespace

SubmissionScripts submission_scripts(BatchSystem system, const Submission& submission) {
  const std::string name = plain_name(submission.name);
  switch (system) {
    case BatchSystem::slurm:
      return {{{name + ".sbatch", slurm_array(submission)}, {name + ".collect.sbatch", slurm_collect(submission)}},
              {"job=$(sbatch --parsable ./" + name + ".sbatch)",
               "sbatch --dependency=afterany:$job ./" + name + ".collect.sbatch"}};
    case BatchSystem::snakemake:
      return {{{"Snakefile", snakefile(submission)},
               {"profile/config.yaml", snakemake_profile(submission)},
               {"profile/status.sh", snakemake_status(), true}},
              {"snakemake --profile profile"}};
    case BatchSystem::parallel:
      break;
  }
  return {{{name + ".parallel.sh", parallel_script(submission), true}}, {"./" + name + ".parallel.sh"}};
}

bool is_submission_text(const std::string& text) {
  return text.substr(0, 80).find(kMark) != std::string::npos;
}

int seconds_of_time_limit(const std::string& text) {
  int hours = 0, minutes = 0, seconds = 0;
  char rest = 0;
  if (text.find_first_not_of("0123456789:") != std::string::npos) return -1;
  // NOLINTNEXTLINE(cert-err34-c): the widths leave no number that an int cannot hold
  if (std::sscanf(text.c_str(), "%4d:%2d:%2d%c", &hours, &minutes, &seconds, &rest) != 3) return -1;
  if (minutes > 59 || seconds > 59) return -1;
  return (hours * 60 + minutes) * 60 + seconds;
}

std::string plain_name(const std::string& name) {
  std::string out;
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = byte < 128 && (std::isalnum(byte) != 0 || c == '_' || c == '-' || (c == '.' && !out.empty()));
    out += plain ? c : '_';
  }
  if (out.empty() || out[0] == '-') out.insert(0, "_");
  return out;
}

std::string shell_word(const std::string& text) {
  return "'" + replace_all(text, {{"'", "'\\''"}}) + "'";
}

std::string python_literal(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') out += '\\';
    out += byte < 0x20 || byte == 0x7F ? fmt::format("\\x{:02x}", byte) : std::string(1, c);
  }
  return out + "\"";
}

}  // namespace reamsim
