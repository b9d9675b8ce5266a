/* fmi2CallbackLogger: its arguments are those of printf, which Rust cannot take. Here they become a text. */
#include <stdarg.h>
#include <stdio.h>

void cosim_deliver(void *environment, int status, const char *category, const char *text);

void cosim_log_fmi2(void *environment, const char *instance, int status, const char *category, const char *message, ...) {
    char text[4096];
    va_list arguments;
    (void)instance;
    va_start(arguments, message);
    if (!message || vsnprintf(text, sizeof text, message, arguments) < 0) {
        text[0] = 0;
    }
    va_end(arguments);
    cosim_deliver(environment, status, category, text[0] ? text : message);
}
