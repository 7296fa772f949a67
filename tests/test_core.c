/* The small modules of src/core. */
#include <stdlib.h>
#include <string.h>

#include "core/files.h"
#include "core/sha256.h"
#include "core/text.h"
#include "support.h"

static void check_sha256(const char *text, size_t length, const char *wanted)
{
    char hex[65];
    cns_sha256_hex(hex, text, length);
    ck_assert_str_eq(hex, wanted);
}

START_TEST(sha256_of_the_standard)
{
    /* FIPS 180-4 examples, and lengths about the block's end */
    check_sha256("", 0, "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
    check_sha256("abc", 3, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    const char *two = "abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq";
    check_sha256(two, 56, "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
    char *million = malloc(1000000);
    memset(million, 'a', 1000000);
    check_sha256(million, 1000000, "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
    check_sha256(million, 55, "9f4390f8d30c2dd92ec9f095b65e2b9ae9b0a925a5258e241c9f1e910f734318");
    check_sha256(million, 56, "b35439a4ac6f0948b6d6f9e3c6af0f5f590ce20f1bde7090ef7970686ec6738a");
    check_sha256(million, 63, "7d3e74a05d7db15bce4ad9ec0658ea98e3f06eeecf16b4c6fff2da457ddc2f34");
    check_sha256(million, 64, "ffe054fe7ae0cb6dc65c3af9b61d5209f439851db43d0ba5997337df154668eb");
    free(million);
}
END_TEST

START_TEST(quotes_and_suggests)
{
    ck_assert_str_eq(cns_quote("a\033b\xff").text, "a?b?");
    ck_assert_str_eq(cns_quote("\xc3\xa9").text, "\xc3\xa9");
    char text[200];
    memset(text, 'x', sizeof text);
    text[199] = '\0';
    ck_assert_uint_lt(strlen(cns_quote(text).text), CNS_QUOTE);
    ck_assert_int_eq(cns_text_distance("digts", "digits"), 1);
    ck_assert_int_eq(cns_text_distance("rnu", "run"), 1);
    ck_assert_int_eq(cns_text_distance("", "abc"), 3);
    ck_assert_int_eq(cns_text_distance("vx", "Vx"), 0);
    ck_assert_int_eq(cns_text_distance("kitten", "sitting"), 3);
}
END_TEST

static void check_fold(const char *text, int width, int hang, const char *wanted)
{
    cns_text_stream s;
    cns_text_open(&s);
    cns_text_fold(s.file, text, width, hang);
    char *folded = cns_text_close(&s, NULL);
    ck_assert_str_eq(folded, wanted);
    free(folded);
}

START_TEST(folds_at_words)
{
    check_fold("one two three four", 9, 0, "one two\nthree\nfour\n");
    check_fold("cns: one two three", 10, 5, "cns: one\n     two\n     three\n");
    check_fold("  key  meaning of it\n\nfour five", 17, 0, "  key  meaning of\n       it\n\nfour five\n");
    check_fold("      -o FILE   where it goes", 16, 0, "      -o FILE\n      where it\n      goes\n");
    check_fold("incomprehensible \xc3\xa9t\xc3\xa9 \xc3\xa9t\xc3\xa9", 7, 2,
               "incomprehensible\n  \xc3\xa9t\xc3\xa9\n  \xc3\xa9t\xc3\xa9\n");
    check_fold("no end", 80, 0, "no end\n");
    check_fold("", 80, 0, "\n");
}
END_TEST

START_TEST(shows_what_is_printable)
{
    char text[] = "a\nb\xff\xc3\xa9\xc2\x85z";
    cns_text_make_printable(text);
    ck_assert_str_eq(text, "a?b?\xc3\xa9?z");
}
END_TEST

Suite *suite_core(void)
{
    Suite *suite = suite_create("core");
    TCase *t = tcase_create("core");
    tcase_add_test(t, sha256_of_the_standard);
    tcase_add_test(t, quotes_and_suggests);
    tcase_add_test(t, folds_at_words);
    tcase_add_test(t, shows_what_is_printable);
    suite_add_tcase(suite, t);
    return suite;
}
