/* SPDX-License-Identifier: MIT
 *
 * Lines of a session: typed at a terminal, with editing, history and completion, or from a pipe.
 */
#include "mpi/session/session_input.h"

#include <ctype.h>
#include <errno.h>
#include <histedit.h>
#include <locale.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <wchar.h>

#include "base/alloc.h"
#include "mpi/parallel/interrupt.h"

enum { HISTORY_LINES = 1000, PATH_NBYTES = 4096 };

struct rmap_session_input {
    FILE *in, *out; /* out: for what steers the terminal; NULL: a pipe */
    char **word;    /* [n_word] */
    size_t n_word;
    EditLine *terminal; /* NULL: a pipe */
    History *history;
    char history_path[PATH_NBYTES]; /* "": nowhere to keep it */
    char *line;
    size_t line_cap;
};

/* One character, for the editor: 1, 0 at the end, -1 when the line is given up. The editor's own
 * function would wait for a key after a signal that came before it began to wait. Ctrl-D between
 * the prompt and the moment when the editor takes the terminal comes as 0. */
static int read_key(EditLine *terminal, wchar_t *key)
{
    enum { LOOK_MS = 100, CTRL_D = 4 };
    FILE *in = NULL;
    mbstate_t state = {0};
    char byte;
    if (el_get(terminal, EL_GETFP, 0, &in) != 0)
        return -1;
    struct pollfd ready = {.fd = fileno(in), .events = POLLIN};
    for (;;) {
        while (poll(&ready, 1, LOOK_MS) <= 0)
            if (rmap_interrupt_stops_question())
                return -1;
        const ssize_t n = read(ready.fd, &byte, 1);
        if (n == 0 || (n < 0 && errno != EINTR && errno != EAGAIN))
            return (int)n;
        if (n == 1 && byte == 0)
            byte = CTRL_D;
        const size_t used = n == 1 ? mbrtowc(key, &byte, 1, &state) : (size_t)-2;
        if (used == (size_t)-1) /* no character: left out */
            memset(&state, 0, sizeof state);
        else if (used != (size_t)-2)
            return 1;
    }
}

static char *prompt(EditLine *terminal)
{
    static char text[] = "raymap> ";
    (void)terminal;
    return text;
}

static bool is_word_byte(char c)
{
    return isalnum((unsigned char)c) || c == '_' || c == '.' || c == '@' || (unsigned char)c >= 128;
}

static void list_words(const struct rmap_session_input *self, const char *stem, size_t len)
{
    putchar('\n');
    for (size_t i = 0, n = 0; i < self->n_word; i++)
        if (strncmp(self->word[i], stem, len) == 0)
            printf("%-19s%c", self->word[i], ++n % 4 == 0 ? '\n' : ' ');
    putchar('\n');
    fflush(stdout);
}

/* Adds what all words that begin like the one at the cursor have in common; lists them when that is
 * nothing. */
static unsigned char complete(EditLine *terminal, int key)
{
    const struct rmap_session_input *self = NULL;
    const LineInfo *info = el_line(terminal);
    const char *stem = info->cursor, *common = NULL;
    size_t common_len = 0, n_found = 0;
    (void)key;
    if (el_get(terminal, EL_CLIENTDATA, &self) != 0 || !self)
        return CC_ERROR;
    while (stem > info->buffer && is_word_byte(stem[-1]))
        stem--;
    size_t len = (size_t)(info->cursor - stem);
    for (size_t i = 0; i < self->n_word; i++) {
        const char *word = self->word[i];
        if (strncmp(word, stem, len) != 0)
            continue;
        if (n_found++ == 0) {
            common = word;
            common_len = strlen(word);
        }
        size_t same = len;
        while (same < common_len && word[same] == common[same])
            same++;
        common_len = same;
    }
    if (n_found == 0)
        return CC_REFRESH_BEEP;
    if (common_len == len && n_found > 1) {
        list_words(self, stem, len);
        return CC_REDISPLAY;
    }
    char *more = rmap_alloc(common_len - len + 1, 1);
    if (!more)
        return CC_ERROR;
    memcpy(more, common + len, common_len - len);
    int failed = common_len > len ? el_insertstr(terminal, more) : 0;
    rmap_free(more);
    return failed ? CC_ERROR : CC_REFRESH;
}

/* Every folder that the path goes through; what fails shows when the file is written. */
static void make_folders(char *path)
{
    for (char *slash = strchr(path + 1, '/'); slash; slash = strchr(slash + 1, '/')) {
        *slash = '\0';
        (void)mkdir(path, 0700);
        *slash = '/';
    }
}

/* $XDG_STATE_HOME/raymap/history, or the same below ~/.local/state; "" without a home. */
static void find_history(char path[PATH_NBYTES])
{
    const char *state = getenv("XDG_STATE_HOME"), *home = getenv("HOME");
    bool has_state = state && *state;
    const char *base = has_state ? state : home;
    int len = -1;
    if (base && *base)
        len = snprintf(path, PATH_NBYTES, "%s%s/raymap/history", base,
                       has_state ? "" : "/.local/state");
    if (len < 0 || len >= PATH_NBYTES)
        path[0] = '\0';
    else
        make_folders(path);
}

static enum rmap_status open_terminal(struct rmap_session_input *self, struct rmap_error *err)
{
    HistEvent event;
    const int fd = dup(STDOUT_FILENO);
    /* Names and criteria are UTF-8, whatever the environment's locale; editing goes by code points.
     */
    if (!setlocale(LC_CTYPE, "C.UTF-8"))
        (void)setlocale(LC_CTYPE, "");
    self->out = fd >= 0 ? fdopen(fd, "w") : NULL;
    if (!self->out && fd >= 0)
        (void)close(fd);
    self->terminal = self->out ? el_init("raymap", self->in, self->out, self->out) : NULL;
    self->history = history_init();
    if (!self->terminal || !self->history)
        return rmap_error_set(err, RMAP_SYSTEM, "the terminal cannot be used for editing lines");
    find_history(self->history_path);
    (void)history(self->history, &event, H_SETSIZE, HISTORY_LINES);
    (void)history(self->history, &event, H_SETUNIQUE, 1);
    if (self->history_path[0])
        (void)history(self->history, &event, H_LOAD, self->history_path);
    (void)el_set(self->terminal, EL_CLIENTDATA, self);
    (void)el_set(self->terminal, EL_PROMPT, prompt);
    (void)el_set(self->terminal, EL_EDITOR, "emacs");
    (void)el_set(self->terminal, EL_SIGNAL, 1);
    (void)el_set(self->terminal, EL_GETCFN, read_key);
    (void)el_set(self->terminal, EL_HIST, history, self->history);
    (void)el_set(self->terminal, EL_ADDFN, "complete", "complete a name", complete);
    (void)el_set(self->terminal, EL_BIND, "^I", "complete", NULL);
    (void)el_source(self->terminal, NULL); /* the user's own keys */
    rmap_interrupt_watch_questions();
    return RMAP_OK;
}

static enum rmap_status copy_words(struct rmap_session_input *self, const char *const *word,
                                   size_t n_word, struct rmap_error *err)
{
    self->word = rmap_alloc(n_word + 1, sizeof *self->word);
    for (; self->word && self->n_word < n_word; self->n_word++)
        if (!(self->word[self->n_word] = rmap_strdup(word[self->n_word])))
            break;
    return self->word && self->n_word == n_word
               ? RMAP_OK
               : rmap_error_set(err, RMAP_SYSTEM, "out of memory for a session's words");
}

enum rmap_status rmap_session_input_create(FILE *in, const char *const *word, size_t n_word,
                                           struct rmap_session_input **input_ret,
                                           struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_session_input *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a session");
    self->in = in;
    if (word) {
        RMAP_TRY(copy_words(self, word, n_word, err));
        RMAP_TRY(open_terminal(self, err));
    }
    *input_ret = self;
    self = NULL;
out:
    rmap_session_input_destroy(self);
    return st;
}

void rmap_session_input_destroy(struct rmap_session_input *self)
{
    HistEvent event;
    if (!self)
        return;
    if (self->history && self->history_path[0])
        (void)history(self->history, &event, H_SAVE, self->history_path);
    if (self->history)
        history_end(self->history);
    if (self->terminal)
        el_end(self->terminal);
    if (self->out)
        (void)fclose(self->out);
    for (size_t i = 0; i < self->n_word; i++)
        rmap_free(self->word[i]);
    rmap_free(self->word);
    free(self->line); /* getline's */
    rmap_free(self);
}

static enum rmap_status next_typed(struct rmap_session_input *self, const char **line_ret,
                                   struct rmap_error *err)
{
    HistEvent event;
    int len = 0;
    const char *typed = el_gets(self->terminal, &len);
    *line_ret = NULL;
    if (!typed || len <= 0) {
        const bool stopped = rmap_interrupt_stops_question(); /* or the input has ended */
        fprintf(self->out, "%s\n", stopped ? "^C" : "");
        fflush(self->out);
        el_reset(self->terminal);
        *line_ret = stopped ? "" : NULL;
        return RMAP_OK;
    }
    if (self->line_cap < (size_t)len + 1) {
        char *grown = realloc(self->line, (size_t)len + 1);
        if (!grown)
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a line");
        self->line = grown;
        self->line_cap = (size_t)len + 1;
    }
    memcpy(self->line, typed, (size_t)len);
    self->line[len - (typed[len - 1] == '\n')] = '\0';
    if (self->line[strspn(self->line, " \t")])
        (void)history(self->history, &event, H_ENTER, self->line);
    *line_ret = self->line;
    return RMAP_OK;
}

enum rmap_status rmap_session_input_next(struct rmap_session_input *self, const char **line_ret,
                                         struct rmap_error *err)
{
    if (self->terminal)
        return next_typed(self, line_ret, err);
    *line_ret = NULL;
    errno = 0;
    ssize_t len = getline(&self->line, &self->line_cap, self->in);
    if (len < 0 && feof(self->in))
        return RMAP_OK;
    if (len < 0)
        return rmap_error_set(err, RMAP_SYSTEM, "a line cannot be read: %s", strerror(errno));
    if ((size_t)len > RMAP_SESSION_LINE)
        return rmap_error_set(err, RMAP_INPUT, "a line of %zd bytes: at most %u are read", len,
                              RMAP_SESSION_LINE);
    if (strlen(self->line) != (size_t)len)
        return rmap_error_set(err, RMAP_INPUT, "the line holds a zero byte");
    if (len > 0 && self->line[len - 1] == '\n')
        self->line[--len] = '\0';
    if (len > 0 && self->line[len - 1] == '\r') /* written elsewhere */
        self->line[--len] = '\0';
    *line_ret = self->line;
    return RMAP_OK;
}
