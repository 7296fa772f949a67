#include "commands.h"

#include <string.h>

#include "core/text.h"

static const cns_command *const commands[] = {
#define COMMAND(name) &cns_command_##name,
#include "commands.def"
#undef COMMAND
};

enum { N_COMMANDS = sizeof commands / sizeof *commands };

const cns_command *cns_command_at(int i)
{
    return i < N_COMMANDS ? commands[i] : NULL;
}

const cns_command *cns_command_find(const char *name)
{
    for (int i = 0; i < N_COMMANDS; i++)
        if (strcmp(commands[i]->name, name) == 0)
            return commands[i];
    return NULL;
}

static const char *name_at(int i, const void *context)
{
    (void)context;
    return commands[i]->name;
}

const char *cns_command_nearest(const char *name)
{
    return cns_text_nearest(name, N_COMMANDS, name_at, NULL);
}
