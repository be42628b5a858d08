/* Takes samples, doubles, from standard input and writes the results, numbers of the type as they are, to
   standard output. Arguments: `whole`; `first` FILE: the first half, and the state into the file; `second`
   FILE: the state from the file, and the second half. Exit code 3: the file was refused. */
#include <stdio.h>
#include <string.h>

#include "MODEL.h"

#ifdef AXES
#define GIVEN AXES_GIVEN
#define FOUND AXES_FOUND
#define INPUT given
#else
#define GIVEN 1
#define FOUND 1
#define INPUT given[0]
#endif
#define MOST 20000

static MODEL_state state;
static double samples[MOST][GIVEN];

int main(int count, char **arguments)
{
    static uint8_t bytes[MODEL_SAVED_BYTES];
    const int is_whole = count == 2 && strcmp(arguments[1], "whole") == 0;
    const int is_first = count == 3 && strcmp(arguments[1], "first") == 0;
    const size_t read = fread(samples, sizeof samples[0], MOST, stdin);
    const size_t end = is_first ? read / 2 : read;
    size_t k = 0;
    FILE *file;
    if (is_whole || is_first) {
        MODEL_init(&state);
    } else {
        file = fopen(arguments[2], "rb");
        if (file == NULL) {
            return 2;
        }
        (void)fread(bytes, 1, sizeof bytes, file);
        (void)fclose(file);
        /* A fresh state has any memory. */
        (void)memset(&state, 0x5A, sizeof state);
        if (MODEL_restore(&state, bytes) != MODEL_OK) {
            return 3;
        }
        k = read / 2;
    }
    for (; k < end; k++) {
        MODEL_real given[GIVEN], found[FOUND];
        size_t i;
        for (i = 0; i < GIVEN; i++) {
            given[i] = (MODEL_real)samples[k][i];
        }
        if (MODEL_step(&state, INPUT, found) < MODEL_OK || fwrite(found, sizeof found, 1, stdout) != 1) {
            return 4;
        }
    }
    if (is_first) {
        MODEL_save(&state, bytes);
        file = fopen(arguments[2], "wb");
        if (file == NULL || fwrite(bytes, sizeof bytes, 1, file) != 1) {
            return 2;
        }
        (void)fclose(file);
    }
    return 0;
}
