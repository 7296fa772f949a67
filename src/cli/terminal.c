#include "terminal.h"

#include <sys/ioctl.h>
#include <unistd.h>

int cns_terminal_columns(int fd)
{
    struct winsize size;
    if (isatty(fd) != 1)
        return 0;
    return ioctl(fd, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : CNS_TEXT_WIDTH;
}

int cns_terminal_width(int fd)
{
    const int columns = cns_terminal_columns(fd);
    return columns < CNS_TEXT_WIDTH ? columns : CNS_TEXT_WIDTH;
}
