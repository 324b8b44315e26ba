/* SPDX-License-Identifier: MIT
 *
 * The manual page and the shell completion, made at build time from the same tables as --help.
 */
#include "mpi/cli/manual.h"

#include <string.h>

#include "version.h"

static void put_roff(char c, FILE *out)
{
    if (c == '\\')
        fputs("\\e", out);
    else if (c == '-')
        fputs("\\-", out);
    else if (c == '\'')
        fputs("\\(aq", out);
    else
        fputc(c, out);
}

/* A blank line begins a paragraph; an indented one is an example and stays as it is. */
static void print_roff(const char *text, FILE *out)
{
    bool line_start = true, example = false;
    for (const char *c = text; *c; c++) {
        if (line_start && (*c == ' ') != example) {
            example = *c == ' ';
            fputs(example ? ".nf\n" : ".fi\n", out);
        }
        if (line_start && *c == '\n')
            fputs(".PP", out);
        if (line_start && *c == '.')
            fputs("\\&", out);
        put_roff(*c, out);
        line_start = *c == '\n';
    }
    fputs(example ? "\n.fi\n" : "\n", out);
}

static void print_option(const struct rmap_option *option, FILE *out)
{
    fputs(".TP\n\\fB", out);
    if (option->letter)
        fprintf(out, "\\-%c\\fR, \\fB", option->letter);
    fputs("\\-\\-", out);
    for (const char *c = option->name; *c; c++)
        put_roff(*c, out);
    fputs("\\fR", out);
    if (option->argument)
        fprintf(out, " \\fI%s\\fR", option->argument);
    fputc('\n', out);
    print_roff(option->help, out);
}

static void print_options(const struct rmap_option *option, FILE *out)
{
    for (; option && option->name; option++)
        print_option(option, out);
}

static void print_command(const struct rmap_command *command, FILE *out)
{
    fprintf(out, ".SS \"raymap %s\"\n.B raymap %s\n", command->name, command->name);
    print_roff(command->operands, out);
    fputs(".PP\n", out);
    print_roff(command->help, out);
    print_options(command->options, out);
}

void rmap_manual_print_command(const struct rmap_command *command, FILE *out)
{
    fprintf(out, ".TH RAYMAP\\-%s 1 \"\" \"raymap %s\" \"User Commands\"\n.nh\n", command->name,
            RMAP_VERSION);
    fprintf(out, ".SH NAME\nraymap\\-%s \\- ", command->name);
    print_roff(command->summary, out);
    fprintf(out, ".SH SYNOPSIS\n.B raymap %s\n", command->name);
    print_roff(command->operands, out);
    fputs(".SH DESCRIPTION\n", out);
    print_roff(command->help, out);
    fputs(".SH OPTIONS\n", out);
    print_options(command->options, out);
    print_options(rmap_common_options(), out);
    fputs(".SH SEE ALSO\n.BR raymap (1),\nwhich has the exit status and all commands\n", out);
}

void rmap_manual_print(const struct rmap_command *const *command, size_t n, FILE *out)
{
    fprintf(out, ".TH RAYMAP 1 \"\" \"raymap %s\" \"User Commands\"\n.nh\n", RMAP_VERSION);
    fputs(
        ".SH NAME\nraymap \\- trace light into a ray map and ask questions about it\n"
        ".SH SYNOPSIS\n.B raymap\n.I command\n[\\fIoptions\\fR] [\\fIoperands\\fR]\n.br\n"
        ".B mpirun \\-np\n.I N\n.B raymap\n.I command\n[\\fIoptions\\fR] [\\fIoperands\\fR]\n"
        ".SH DESCRIPTION\nTraces light through a scene, keeps every ray\\(aqs whole history in a\n"
        "sharded, compressed, self\\-describing HDF5 ray map, and answers questions about those\n"
        "histories. Each command runs alone or under mpirun; the answer is the same. Results go\n"
        "to stdout, everything else to stderr. Options may stand before or after operands.\n",
        out);
    for (size_t i = 0; i < n; i++) {
        fprintf(out, ".TP\n.B %s\n", command[i]->name);
        print_roff(command[i]->summary, out);
    }
    fputs(".SH OPTIONS OF EVERY COMMAND\n", out);
    print_options(rmap_common_options(), out);
    fputs(".SH COMMANDS\n", out);
    for (size_t i = 0; i < n; i++)
        print_command(command[i], out);
    fputs(".SH EXIT STATUS\n"
          ".TP\n0\ndone, also when nothing matches\n"
          ".TP\n1\ninternal error\n"
          ".TP\n2\nwrong usage, or the output exists\n"
          ".TP\n3\nwrong input: scene, criterion, name, missing file\n"
          ".TP\n4\ndamaged or foreign map\n"
          ".TP\n5\nthe system failed: disk full, no memory, no permission\n"
          ".TP\n6\nstopped early by a signal or a time limit; the map holds what was traced\n"
          ".TP\n7\ntraced to the end, but more than 0.1 % of the rays ended in an error\n"
          ".SH EXAMPLES\n.nf\n"
          "mpirun \\-np 4 raymap trace lens.yaml \\-o lens.raymap \\-n 10M\n"
          "raymap query lens.raymap \\(aqregistered(sensor where ghost_order >= 1)\\(aq\n"
          "raymap detector lens.raymap sensor \\-o sensor.png\n"
          ".fi\n.SH SEE ALSO\nThe scene file, the criterion language and the format of a map are\n"
          "described in the pages scene.md, criterion.md and map.md of the documentation.\n"
          ".BR mpirun (1),\n.BR h5dump (1)",
          out);
    for (size_t i = 0; i < n; i++)
        fprintf(out, ",\n.BR raymap\\-%s (1)", command[i]->name);
    fputc('\n', out);
}

/* What the argument of each option may be; of a command that takes MAP NAME, the name, too. */
static void print_values(const struct rmap_command *command, FILE *out)
{
    fputs("            case $before in", out);
    for (const struct rmap_option *option = command->options; option && option->name; option++)
        if (option->words) {
            fprintf(out, "\n                --%s", option->name);
            if (option->letter)
                fprintf(out, " | -%c", option->letter);
            fprintf(out, ") values='%s' ;;", option->words);
        }
    if (strncmp(command->operands, "MAP NAME", strlen("MAP NAME")) == 0)
        fputs("\n                *) ((COMP_CWORD == 3)) && values=@detectors ;;", out);
    fputs("\n            esac ;;\n", out);
}

static void print_words(const struct rmap_option *option, FILE *out)
{
    for (; option && option->name; option++)
        fprintf(out, " --%s", option->name);
}

void rmap_completion_print(const struct rmap_command *const *command, size_t n, FILE *out)
{
    fputs("# bash completion of raymap, made from its tables of options\n"
          "_raymap()\n{\n"
          "    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} "
          "options= values=\n"
          "    if ((COMP_CWORD == 1)); then\n"
          "        mapfile -t COMPREPLY < <(compgen -W \"--help --version",
          out);
    for (size_t i = 0; i < n; i++)
        fprintf(out, " %s", command[i]->name);
    fputs("\" -- \"$word\")\n        return\n    fi\n    case ${COMP_WORDS[1]} in\n", out);
    for (size_t i = 0; i < n; i++) {
        fprintf(out, "        %s) options='", command[i]->name);
        print_words(command[i]->options, out);
        fputs("'\n", out);
        print_values(command[i], out);
    }
    fputs("    esac\n    options+='", out);
    print_words(rmap_common_options(), out);
    /* Everything else is left to bash's own completion of file names. */
    fputs("'\n    COMPREPLY=()\n    if [[ $word == -* && $before != -[ow] ]]; then\n"
          "        values=$options\n"
          "    elif [[ $values == @* ]]; then\n"
          "        values=$(\"${COMP_WORDS[0]}\" help --names \"${values#@}\" \"${COMP_WORDS[2]}\" "
          "2>/dev/null)\n    fi\n"
          "    if [[ $values ]]; then\n"
          "        mapfile -t COMPREPLY < <(compgen -W \"$values\" -- \"$word\")\n    fi\n}\n"
          "complete -o default -F _raymap raymap\n",
          out);
}
